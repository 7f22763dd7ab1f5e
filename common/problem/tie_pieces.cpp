// Pieces of a body: the nodes of one hang on those of another.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "common/base/error.hpp"
#include "common/problem/build.hpp"
#include "common/problem/mortar.hpp"

namespace ricochet::scene {
namespace {

/// Of an edge: surfaces that lie farther from each other are not one.
constexpr double one_place = 1e-6;
/// A smaller weight is round-off.
constexpr double least_weight = 1e-12;

using Carriers = std::vector<fem::WeightedNode>;

struct TiedSide {
  std::string name;
  std::vector<SurfaceFace> faces;  ///< none of a bar, whose surface is a node
  std::vector<int> nodes;
  double edge_m = 0.0;  ///< mean
};

class Ties {
 public:
  Ties(const Scene& scene, const Body& body, fem::Mesh& mesh) : scene_(scene), body_(body), mesh_(mesh) {
    for (const fem::HangingNode& of : mesh.hanging) hanging_[of.node] = of.carriers;
  }

  void tie(std::size_t index) {
    key_ = fmt::format("body.{}.mesh.tie[{}].surfaces", body_.name, index);
    const auto& surfaces = body_.ties[index];
    TiedSide fine = side_of(surfaces[0]), coarse = side_of(surfaces[1]);
    if (coarse.edge_m < fine.edge_m) std::swap(fine, coarse);
    std::map<int, Carriers> tied;
    if (mesh_.model == Model::bar) {
      tied[fine.nodes.front()] = {{coarse.nodes.front(), 1.0}};
    } else {
      const OppositeFaces opposite(coarse.faces, Eigen::Vector2d::Zero());
      for (const MortarRow& row : opposite.rows(fine.faces, Eigen::Vector3d::Zero())) tied[row.node] = row.opposite;
    }
    if (tied.empty())
      refuse(fmt::format("\"{}\" and \"{}\", which lie nowhere opposite each other", fine.name, coarse.name),
             "surfaces of two pieces that lie on each other");
    for (auto& [node, carriers] : tied) {
      std::erase_if(carriers, [](const auto& of) { return std::abs(of.weight) < least_weight; });
      require_one_place(node, carriers, fine, coarse);
      if (!hanging_.emplace(node, carriers).second)
        refuse(fmt::format("node at {} of \"{}\", which hangs already, by mesh.refine or by another tie",
                           place_text(node), fine.name),
               "ties whose finer surfaces share no node, and boxes away from them");
    }
  }

  /// Carriers that hang give way to theirs.
  void finish() {
    mesh_.hanging.clear();
    for (const auto& [node, carriers] : hanging_) {
      std::map<int, double> sums;
      std::set<int> on_the_way;
      add(node, 1.0, on_the_way, sums);
      fem::HangingNode& of = mesh_.hanging.emplace_back();
      of.node = node;
      for (const auto& [carrier, weight] : sums) of.carriers.push_back({carrier, weight});
    }
  }

  /// Every piece hangs together with the first.
  void require_all() {
    std::map<int, std::size_t> piece_of_node;
    for (std::size_t p = 0; p < body_.pieces.size(); ++p)
      for (const int element : mesh_.element_groups.at(body_.pieces[p].name))
        for (const int node : mesh_.elements[at(element)]) piece_of_node[node] = p;
    std::vector<std::size_t> root(body_.pieces.size());
    for (std::size_t p = 0; p < root.size(); ++p) root[p] = p;
    for (const auto& [node, carriers] : hanging_) {
      const std::size_t one = root[piece_of_node.at(node)], other = root[piece_of_node.at(carriers.front().node)];
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
    TiedSide side{surface, {}, fem::surface_nodes(mesh_, surface)};
    if (mesh_.model == Model::bar) return side;
    for (const fem::Face& nodes : mesh_.surfaces.at(surface)) {
      SurfaceFace& face = side.faces.emplace_back(SurfaceFace{nodes, {}, {}, fem::face_normal(mesh_, nodes)});
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        face.x[i] = mesh_.position[at(nodes[i])];
        face.measure[i] = mesh_.model == Model::axisymmetric ? 2.0 * std::numbers::pi * face.x[i][0] : 1.0;
        face.node_normal[i] = face.normal;
        side.edge_m += (mesh_.position[at(nodes[(i + 1) % nodes.size()])] - face.x[i]).norm() /
                       static_cast<double>(nodes.size() * mesh_.surfaces.at(surface).size());
      }
    }
    return side;
  }

  /// Weights that give a node the place where it is give it every motion of a rigid body and every even strain.
  void require_one_place(int node, const Carriers& carriers, const TiedSide& fine, const TiedSide& coarse) const {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    for (const auto& carrier : carriers) place += carrier.weight * mesh_.position[at(carrier.node)];
    const double apart_m = (place - mesh_.position[at(node)]).norm();
    const double edge_m = mesh_.model == Model::bar ? extent_m() : fine.edge_m;
    if (apart_m <= one_place * edge_m) return;
    refuse(fmt::format("\"{}\" {:.3g} m away from \"{}\" at {}", fine.name, apart_m, coarse.name, place_text(node)),
           "surfaces of two pieces that lie on each other, flat or with the same faces");
  }
  [[nodiscard]] double extent_m() const {
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& x : mesh_.position) box.extend(x);
    return box.diagonal().norm();
  }

  void add(int node, double weight, std::set<int>& on_the_way, std::map<int, double>& sums) const {
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
    for (const auto& carrier : found->second) add(carrier.node, weight * carrier.weight, on_the_way, sums);
    on_the_way.erase(node);
  }

  const Scene& scene_;
  const Body& body_;
  fem::Mesh& mesh_;
  std::string key_;
  std::map<int, Carriers> hanging_;
};

}  // namespace

void tie_pieces(const Scene& scene, const Body& body, fem::Mesh& mesh) {
  Ties ties(scene, body, mesh);
  for (std::size_t i = 0; i < body.ties.size(); ++i) ties.tie(i);
  ties.require_all();
  ties.finish();
}

}  // namespace ricochet::scene
