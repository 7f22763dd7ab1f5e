#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "common/problem/build.hpp"

namespace ricochet::scene {
namespace {

/// A share of a body's extent: a position this close to a node is that node's.
constexpr double same_place = 1e-6;

double extent_m(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position.front(), high = low;
  for (const Eigen::Vector3d& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

/// Finds the nodes of a mesh by their places.
class Places {
 public:
  explicit Places(const fem::Mesh& mesh) : mesh_(mesh), tolerance_m_(same_place * extent_m(mesh)) {
    for (int node = 0; node < static_cast<int>(mesh.position.size()); ++node) order_.push_back(node);
    std::sort(order_.begin(), order_.end(), [&](int a, int b) { return along(a) < along(b); });
  }

  /// -1: none is there.
  [[nodiscard]] int at_place(const Eigen::Vector3d& x) const {
    const auto first = std::lower_bound(order_.begin(), order_.end(), x[0] - tolerance_m_,
                                        [&](int node, double low) { return along(node) < low; });
    for (auto node = first; node != order_.end() && along(*node) <= x[0] + tolerance_m_; ++node)
      if ((mesh_.position[at(*node)] - x).norm() <= tolerance_m_) return *node;
    return -1;
  }

  [[nodiscard]] int nearest(const Eigen::Vector3d& x) const {
    return *std::min_element(order_.begin(), order_.end(), [&](int a, int b) {
      return (mesh_.position[at(a)] - x).squaredNorm() < (mesh_.position[at(b)] - x).squaredNorm();
    });
  }

 private:
  [[nodiscard]] double along(int node) const { return mesh_.position[at(node)][0]; }

  const fem::Mesh& mesh_;
  double tolerance_m_;
  std::vector<int> order_;  ///< nodes by their first coordinate
};

/// The nodes at the positions of the file.
std::vector<int> nodes_of_file(const Scene& scene, const ForeignBody& foreign, const BodyProblem& body) {
  const auto components = at(scene.components());
  const auto refuse = [&](const Eigen::Vector3d& x, const std::string& found, const std::string& allowed) {
    throw ConfigError(fmt::format("{}: found the position {} in {}{}; allowed: {}",
                                  scene.where("body." + foreign.name + ".interface_nodes"),
                                  fem::place_text(scene.model, x), foreign.interface_nodes, found, allowed));
  };
  const Places places(body.mesh);
  std::vector<int> nodes;
  std::vector<bool> taken(body.mesh.position.size(), false);
  for (std::size_t row = 0; row < foreign.interface_position_m.size() / components; ++row) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (std::size_t c = 0; c < components; ++c)
      x[static_cast<Eigen::Index>(c)] = foreign.interface_position_m[row * components + c];
    const int node = places.at_place(x);
    if (node < 0)
      refuse(x, "",
             fmt::format("positions of nodes of \"{}\", the nearest of which is at {}", body.name,
                         fem::place_text(scene.model, body.mesh.position[at(places.nearest(x))])));
    if (taken[at(node)]) refuse(x, " a second time", "each node once");
    taken[at(node)] = true;
    nodes.push_back(node);
  }
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

}  // namespace

std::vector<Joint> build_joints(const Scene& scene, std::vector<BodyProblem>& bodies) {
  for (BodyProblem& body : bodies) body.joined_node.assign(body.mesh.position.size(), false);
  std::vector<Joint> joints;
  for (const ForeignBody& foreign : scene.foreign_bodies) {
    const auto body = std::find_if(bodies.begin(), bodies.end(),
                                   [&](const BodyProblem& other) { return other.name == foreign.joined_to; });
    Joint joint{foreign.name, static_cast<int>(body - bodies.begin()), {}};
    if (!foreign.faces.empty()) {
      joint.nodes = body->mesh.foreign_nodes.at(foreign.name);
    } else if (foreign.interface_nodes.empty()) {
      require_surface(scene, "body." + foreign.name + ".surface", body->mesh, foreign.surface);
      joint.nodes = fem::surface_nodes(body->mesh, foreign.surface);
      std::sort(joint.nodes.begin(), joint.nodes.end());
    } else {
      joint.nodes = nodes_of_file(scene, foreign, *body);
    }
    for (const int node : joint.nodes) {
      if (fem::hanging_at(body->mesh, node) != nullptr)
        throw ConfigError(fmt::format(
            "{}: found a joined node at {}, which hangs on larger elements; allowed: nodes "
            "inside or outside of the boxes of mesh.refine, and of the coarser side of a tie",
            scene.where("body." + foreign.name), fem::place_text(scene.model, body->mesh.position[at(node)])));
      body->joined_node[at(node)] = true;
    }
    joints.push_back(std::move(joint));
  }
  return joints;
}

}  // namespace ricochet::scene
