// Pieces of a body: the nodes of one hang on those of another.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <tuple>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"
#include "common/surface/box_tree.hpp"
#include "common/surface/face_plane.hpp"
#include "common/surface/mortar.hpp"

namespace ricochet::scene {
namespace {

/// Surfaces that lie farther from each other than this share of an edge are not one.
constexpr double one_place = 1e-6;
/// A node that lies beside the other surface by more than this share of a face is free. The rim of a fine disc stands
/// off that of a coarse one by less.
constexpr double most_beside = 0.25;
/// A smaller weight is round-off.
constexpr double least_weight = 1e-12;

using Carriers = std::vector<fem::WeightedNode>;

struct Hanging {
  Carriers carriers, between, beside;
};

struct TiedSide {
  std::string name;
  std::vector<surface::SurfaceFace> faces;  ///< none of a bar, whose surface is a node
  std::vector<int> nodes;
  double edge_m = 0.0;  ///< mean
};

class Ties {
 public:
  Ties(const Scene& scene, const Body& body, fem::Mesh& mesh) : scene_(scene), body_(body), mesh_(mesh) {
    for (const fem::HangingNode& of : mesh.hanging) hanging_[of.node] = {of.carriers, of.carriers, of.carriers};
  }

  void tie(std::size_t index) {
    key_ = fmt::format("body.{}.mesh.tie[{}].surfaces", body_.name, index);
    const auto& surfaces = body_.ties[index];
    TiedSide fine = side_of(surfaces[0]), coarse = side_of(surfaces[1]);
    if (coarse.edge_m < fine.edge_m) std::swap(fine, coarse);
    hang(fine, coarse, "surfaces of two pieces that lie on each other, flat or with the same faces");
  }

  /// The nodes of the surface that it is joined to hang on a foreign body's.
  void tie(const ForeignBody& foreign) {
    key_ = fmt::format("body.{}.interface_faces", foreign.name);
    if (mesh_.period_m > 0.0)
      refuse(fmt::format("faces at \"{}\", whose mesh repeats", body_.name), "periodic_across = false");
    const TiedSide fine = side_of(foreign.surface);
    TiedSide coarse{"the faces of " + foreign.interface_faces, {}, {}};
    const auto components = at(scene_.components());
    for (std::size_t first = 0; first < foreign.interface_position_m.size(); first += components) {
      Eigen::Vector3d& x = mesh_.position.emplace_back(Eigen::Vector3d::Zero());
      for (std::size_t c = 0; c < components; ++c)
        x[static_cast<Eigen::Index>(c)] = foreign.interface_position_m[first + c];
      coarse.nodes.push_back(static_cast<int>(mesh_.position.size()) - 1);
    }
    mesh_.foreign_nodes[foreign.name] = coarse.nodes;
    std::vector<bool> used(coarse.nodes.size(), false);
    for (const std::vector<int>& rows : foreign.faces) {
      fem::Face face{};
      for (const int row : rows) {
        face.push_back(coarse.nodes[at(row)]);
        used[at(row)] = true;
      }
      if (fem::face_normal(mesh_, face).dot(fine.faces.front().normal) > 0.0) std::reverse(face.begin(), face.end());
      add(face, foreign.faces.size(), coarse);
    }
    for (std::size_t row = 0; row < used.size(); ++row)
      if (!used[row])
        refuse(fmt::format("no face with the node of row {}", row),
               "faces that have every node of " + foreign.interface_nodes);
    hang(fine, coarse, fmt::format("faces that lie on \"{}\", flat or with the same faces", foreign.surface));
  }

  /// Carriers that hang give way to theirs.
  void finish() {
    mesh_.hanging.clear();
    for (const auto& [node, own] : hanging_) {
      fem::HangingNode& of = mesh_.hanging.emplace_back();
      of.node = node;
      of.carriers = resolved(node, &Hanging::carriers);
      of.between = resolved(node, &Hanging::between);
      of.beside = resolved(node, &Hanging::beside);
    }
  }

  /// Every piece hangs together with the first.
  void require_all() {
    std::vector<std::size_t> piece_of_node(mesh_.position.size(), 0);
    for (std::size_t p = 0; p < body_.pieces.size(); ++p)
      for (const int element : mesh_.element_groups.at(body_.pieces[p].name))
        for (const int node : mesh_.elements[at(element)]) piece_of_node[at(node)] = p;
    std::vector<std::size_t> root(body_.pieces.size());
    for (std::size_t p = 0; p < root.size(); ++p) root[p] = p;
    for (const auto& [node, of] : hanging_) {
      const std::size_t one = root[piece_of_node[at(node)]], other = root[piece_of_node[at(of.carriers.front().node)]];
      std::ranges::replace(root, std::max(one, other), std::min(one, other));
    }
    for (std::size_t p = 0; p < root.size(); ++p)
      if (root[p] != 0)
        throw ConfigError(
            fmt::format("{}: found piece \"{}\", which no tie joins to \"{}\"; allowed: pieces that "
                        "[[body.mesh.tie]] joins to one body, or a body of its own",
                        scene_.where("body." + body_.name + ".mesh"), body_.pieces[p].name, body_.pieces.front().name));
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw ConfigError(fmt::format("{}: found {}; allowed: {}", scene_.where(key_), found, allowed));
  }
  [[nodiscard]] std::string place_text(int node) const {
    return fem::place_text(mesh_.model, mesh_.position[at(node)]);
  }

  [[nodiscard]] TiedSide side_of(const std::string& surface) const {
    require_surface(scene_, key_, mesh_, surface);
    TiedSide side{"\"" + surface + "\"", {}, fem::surface_nodes(mesh_, surface)};
    if (mesh_.model == Model::bar) return side;
    for (const fem::Face& face : mesh_.surfaces.at(surface)) add(face, mesh_.surfaces.at(surface).size(), side);
    return side;
  }
  /// A face of `count`.
  void add(const fem::Face& nodes, std::size_t count, TiedSide& side) const {
    surface::SurfaceFace& face =
        side.faces.emplace_back(surface::SurfaceFace{nodes, {}, {}, fem::face_normal(mesh_, nodes)});
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      face.x[i] = mesh_.position[at(nodes[i])];
      face.measure[i] = mesh_.model == Model::axisymmetric ? 2.0 * std::numbers::pi * face.x[i][0] : 1.0;
      face.node_normal[i] = face.normal;
      side.edge_m += (mesh_.position[at(nodes[(i + 1) % nodes.size()])] - face.x[i]).norm() /
                     static_cast<double>(nodes.size() * count);
    }
  }

  void hang(const TiedSide& fine, const TiedSide& coarse, const std::string& allowed) {
    const std::map<int, Hanging> tied = hanging_of(fine, coarse);
    if (tied.empty())
      refuse(fmt::format("{} and {}, which lie nowhere opposite each other", fine.name, coarse.name), allowed);
    for (const auto& [node, of] : tied) {
      require_one_place(node, of.carriers, fine, coarse, allowed);
      if (!hanging_.emplace(node, of).second)
        refuse(fmt::format("node at {} of {}, which hangs already, by mesh.refine or by another tie", place_text(node),
                           fine.name),
               "ties whose finer surfaces share no node, and boxes away from them");
    }
  }

  /// Weights that give a node the place where it is give it every motion of a rigid body and every even strain.
  void require_one_place(int node, const Carriers& carriers, const TiedSide& fine, const TiedSide& coarse,
                         const std::string& allowed) const {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (const auto& carrier : carriers) place += carrier.weight * mesh_.position[at(carrier.node)];
    const double apart_m = (place - mesh_.position[at(node)]).norm();
    const double edge_m = mesh_.model == Model::bar ? extent_m() : fine.edge_m;
    if (apart_m <= one_place * edge_m) return;
    refuse(fmt::format("{} {:.3g} m away from {} at {}", fine.name, apart_m, coarse.name, place_text(node)), allowed);
  }
  [[nodiscard]] double extent_m() const {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : mesh_.position) box.extend(x);
    return box.diagonal().norm();
  }

  /// A node that lies beside the coarse side is left free.
  [[nodiscard]] std::map<int, Hanging> hanging_of(const TiedSide& fine, const TiedSide& coarse) const {
    if (mesh_.model == Model::bar) {
      const Carriers other{{coarse.nodes.front(), 1.0}};
      return {{fine.nodes.front(), {other, other, other}}};
    }
    std::map<int, Hanging> tied;
    const surface::OppositeFaces opposite(coarse.faces, Eigen::Vector2d::Zero());
    const surface::BoxTree tree(surface::boxes_of(coarse.faces, Eigen::Vector3d::Zero()));
    for (const surface::MortarRow& row : opposite.rows_of_tie(fine.faces)) {
      Hanging of{row.opposite, between(row, tree, fine, coarse), row.overlap};
      std::erase_if(of.carriers, [](const auto& carrier) { return std::abs(carrier.weight) < least_weight; });
      if (!of.between.empty()) tied[row.node] = std::move(of);
    }
    return tied;
  }

  /// Shape functions of the face that the line along the normal of a node hits, none of them negative.
  [[nodiscard]] Carriers between(const surface::MortarRow& row, const surface::BoxTree& tree, const TiedSide& fine,
                                 const TiedSide& coarse) const {
    const Eigen::Vector3d& place = mesh_.position[at(row.node)];
    const double reach_m = std::max(fine.edge_m, coarse.edge_m);
    surface::Hit best{-most_beside, 0.0};
    const surface::SurfaceFace* face = nullptr;
    tree.visit([&](const Eigen::AlignedBox3d& box) { return box.squaredExteriorDistance(place) < reach_m * reach_m; },
               [&](std::size_t i) {
                 const surface::Hit hit = surface::hit_of(place, row.normal, coarse.faces[i]);
                 if (hit.inside > best.inside) std::tie(best, face) = std::pair(hit, &coarse.faces[i]);
               });
    Carriers nodes;
    for (std::size_t k = 0; face != nullptr && k < face->node.size(); ++k)
      if (const double weight = best.shape[static_cast<Eigen::Index>(k)]; weight > least_weight)
        nodes.push_back({face->node[k], weight});
    double sum = 0.0;
    for (const auto& of : nodes) sum += of.weight;
    for (auto& of : nodes) of.weight /= sum;
    return nodes;
  }

  [[nodiscard]] Carriers resolved(int node, Carriers Hanging::*kind) const {
    std::map<int, double> sums;
    std::set<int> on_the_way;
    add(node, 1.0, kind, on_the_way, sums);
    Carriers all;
    for (const auto& [carrier, weight] : sums) all.push_back({carrier, weight});
    return all;
  }
  void add(int node, double weight, Carriers Hanging::*kind, std::set<int>& on_the_way,
           std::map<int, double>& sums) const {
    const auto found = hanging_.find(node);
    if (found == hanging_.end()) {
      sums[node] += weight;
      return;
    }
    if (!on_the_way.insert(node).second)
      throw ConfigError(
          fmt::format("{}: found ties by which the node at {} hangs on itself; allowed: surfaces of two pieces in each "
                      "tie, and none tied in a ring by its edges",
                      scene_.where("body." + body_.name + ".mesh"), place_text(node)));
    for (const auto& carrier : found->second.*kind) add(carrier.node, weight * carrier.weight, kind, on_the_way, sums);
    on_the_way.erase(node);
  }

  const Scene& scene_;
  const Body& body_;
  fem::Mesh& mesh_;
  std::string key_;
  std::map<int, Hanging> hanging_;
};

}  // namespace

void tie_pieces(const Scene& scene, const Body& body, fem::Mesh& mesh) {
  const auto own_mesh = [&](const ForeignBody& foreign) {
    return foreign.joined_to == body.name && !foreign.faces.empty();
  };
  if (!body.of_pieces() && std::ranges::none_of(scene.foreign_bodies, own_mesh)) return;
  Ties ties(scene, body, mesh);
  for (std::size_t i = 0; i < body.ties.size(); ++i) ties.tie(i);
  if (body.of_pieces()) ties.require_all();
  for (const ForeignBody& foreign : scene.foreign_bodies)
    if (own_mesh(foreign)) ties.tie(foreign);
  ties.finish();
}

}  // namespace ricochet::scene
