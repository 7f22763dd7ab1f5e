#include "coupler/interface/interface_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

constexpr double largest_mass_kg = InterfaceMap::largest_mass_kg;

/// One interface node of one participant.
struct Node {
  std::size_t participant = 0;
  int row = 0;
  std::string body;
  double position[3] = {0.0, 0.0, 0.0};
  double mass_kg = 0.0;
  bool implicit = false;
  std::string where;  ///< "participant 'x', body 'y', (1, 2) m" for error texts
};

void require(bool condition, const std::string& text) {
  if (!condition) throw ProtocolError(text);
}

std::vector<Node> nodes_of(const PeerDescription& description, std::size_t participant) {
  const int components = static_cast<int>(description.components);
  const int count = description.interface_position_m.rows;
  const auto says = [&](const std::string& what) {
    return fmt::format("participant '{}' {}", description.participant, what);
  };
  require(components >= 1 && components <= 3,
          says(fmt::format("has {} components per node, allowed are 1 to 3", components)));
  const auto require_shape = [&](const wire::Array& array, const char* field, int columns) {
    const auto size = static_cast<std::size_t>(count) * static_cast<std::size_t>(columns);
    require(
        array.rows == count && (array.columns == columns || count == 0) && array.data.size() == size,
        says(fmt::format("describes its interface with arrays of different shapes: '{}' is {} x {}, expected {} x {}",
                         field, array.rows, array.columns, count, columns)));
  };
  require_shape(description.interface_position_m, "interface_position_m", components);
  require_shape(description.interface_body, "interface_body", 1);
  require_shape(description.interface_mass_kg, "interface_mass_kg", 1);
  const bool implicit = description.role == Role::implicit_solver;
  std::vector<Node> nodes(count);
  for (int i = 0; i < count; ++i) {
    Node& node = nodes[i];
    const double body = description.interface_body.data[i];
    require(body >= 0 && body < static_cast<double>(description.bodies.size()) && body == std::floor(body),
            says(fmt::format("gives interface node {} the body number {}, it has {} bodies", i, body,
                             description.bodies.size())));
    node.participant = participant;
    node.row = i;
    node.body = description.bodies[static_cast<std::size_t>(body)];
    node.mass_kg = description.interface_mass_kg.data[i];
    node.implicit = implicit;
    std::copy_n(description.interface_position_m.data.begin() + static_cast<std::ptrdiff_t>(i) * components, components,
                node.position);
    const auto* begin = node.position;
    node.where = fmt::format("participant '{}', body '{}', node {} at ({}) m", description.participant, node.body, i,
                             fmt::join(begin, begin + components, ", "));
    require(node.mass_kg >= 0, fmt::format("{}: its lumped mass {} kg is negative", node.where, node.mass_kg));
    require(node.mass_kg <= largest_mass_kg,
            fmt::format("{}: its lumped mass 'interface_mass_kg' is {:g} kg, allowed are at most {:g}", node.where,
                        node.mass_kg, largest_mass_kg));
  }
  return nodes;
}

/// Largest extent of all nodes along any component [m]; 0 if they lie in one point.
double extent(const std::vector<Node>& nodes) {
  double result = 0.0;
  for (int c = 0; c < 3; ++c) {
    const auto [low, high] = std::minmax_element(
        nodes.begin(), nodes.end(), [c](const Node& a, const Node& b) { return a.position[c] < b.position[c]; });
    if (low != nodes.end()) result = std::max(result, high->position[c] - low->position[c]);
    // A single point has no extent; its distance from the origin then bounds the rounding of its coordinates.
    if (low != nodes.end()) result = std::max(result, std::abs(high->position[c]));
  }
  return result;
}

/// Groups nodes that coincide: for each shared node the indices of `nodes` that are it, in ascending order.
/// A hash of cells as large as the tolerance finds candidates; a node may lie next to a cell border, so neighbours
/// count.
class Matcher {
 public:
  explicit Matcher(double tolerance) : cell_(tolerance > 0 ? 4 * tolerance : 1.0), tolerance_(tolerance) {}

  /// Index of the group the node joins; `groups` grows by one if it meets no other.
  std::size_t place(const Node& node, const std::vector<Node>& nodes, std::vector<std::vector<std::size_t>>& groups) {
    long long home[3];
    for (int c = 0; c < 3; ++c) home[c] = static_cast<long long>(std::floor(node.position[c] / cell_));
    for (int k = 0; k < 27; ++k) {
      const auto found = cells_.find(key(node.body, home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1));
      if (found == cells_.end()) continue;
      for (const std::size_t group : found->second) {
        if (near(node, nodes[groups[group].front()])) return group;
      }
    }
    groups.emplace_back();
    cells_[key(node.body, home[0], home[1], home[2])].push_back(groups.size() - 1);
    return groups.size() - 1;
  }

 private:
  static std::string key(const std::string& body, long long i, long long j, long long k) {
    return fmt::format("{}/{}/{}/{}", body, i, j, k);
  }
  [[nodiscard]] bool near(const Node& a, const Node& b) const {
    if (a.body != b.body) return false;
    for (int c = 0; c < 3; ++c) {
      if (std::abs(a.position[c] - b.position[c]) > tolerance_) return false;
    }
    return true;
  }

  double cell_, tolerance_;
  std::unordered_map<std::string, std::vector<std::size_t>> cells_;
};

/// Every shared node needs at least two owners, each once, exactly one of them implicit.
void check_owners(const std::vector<std::size_t>& group, const std::vector<Node>& nodes) {
  const Node& first = nodes[group.front()];
  require(group.size() >= 2, fmt::format("the interface node of {} has no partner: no other participant has a node of "
                                         "body '{}' there",
                                         first.where, first.body));
  int implicit_owners = 0;
  for (std::size_t i = 0; i < group.size(); ++i) {
    const Node& node = nodes[group[i]];
    implicit_owners += node.implicit ? 1 : 0;
    for (std::size_t j = 0; j < i; ++j) {
      require(nodes[group[j]].participant != node.participant,
              fmt::format("two interface nodes of one participant coincide: {} and node {}", node.where,
                          nodes[group[j]].row));
    }
  }
  require(implicit_owners == 1,
          fmt::format("the shared node of {} is integrated by {} implicit participants, it needs exactly one",
                      first.where, implicit_owners));
}

}  // namespace

InterfaceRows::InterfaceRows(std::vector<int> shared, int components)
    : shared_(std::move(shared)), nodes_(shared_.size()), components_(components) {
  const auto numbers = static_cast<std::size_t>(components_);
  for (std::size_t i = 0; i < shared_.size(); ++i) {
    if (i == 0 || shared_[i] != shared_[i - 1] + 1) {
      blocks_.push_back({i * numbers, static_cast<std::size_t>(shared_[i]) * numbers, 0});
    }
    blocks_.back().count += numbers;
  }
}

std::vector<std::size_t> InterfaceRows::dofs() const {
  std::vector<std::size_t> result;
  for (const int node : shared_) {
    for (int c = 0; c < components_; ++c) result.push_back(static_cast<std::size_t>(node * components_ + c));
  }
  return result;
}

std::vector<double> InterfaceRows::per_node(const std::vector<double>& shared_values) const {
  std::vector<double> own;
  for (const int node : shared_) own.push_back(shared_values[static_cast<std::size_t>(node)]);
  return own;
}

/// each(own number, shared number). Participants that take their nodes from the same mesh mostly have them in the same
/// order: then the loops are long, and the compiler makes vectors of them.
template <class Own, class Shared, class Each>
void InterfaceRows::each_number(Own* own_values, Shared* shared_values, Each each) const {
  for (const auto& block : blocks_) {
    Own* own = own_values + block.own;
    Shared* shared = shared_values + block.shared;
    for (std::size_t i = 0; i < block.count; ++i) each(own[i], shared[i]);
  }
}

void InterfaceRows::gather(const std::vector<double>& shared_values, std::vector<double>& own_values) const {
  own_values.resize(nodes_ * static_cast<std::size_t>(components_));
  each_number(own_values.data(), shared_values.data(), [](double& own, const double& shared) { own = shared; });
}

void InterfaceRows::scatter(const std::vector<double>& own_values, std::vector<double>& shared_values) const {
  each_number(own_values.data(), shared_values.data(), [](const double& own, double& shared) { shared = own; });
}

void InterfaceRows::add(const std::vector<double>& own_values, std::vector<double>& shared_values) const {
  each_number(own_values.data(), shared_values.data(), [](const double& own, double& shared) { shared += own; });
}

void InterfaceRows::add_matrix(const Eigen::MatrixXd& own, Eigen::MatrixXd& shared_matrix) const {
  const auto to = dofs();
  shared_matrix(to, to) += own;
}

InterfaceMap::InterfaceMap(const std::vector<PeerDescription>& descriptions) {
  std::vector<Node> nodes;  // the implicit participant's first, then the scene's order
  for (const bool implicit : {true, false}) {
    for (std::size_t p = 0; p < descriptions.size(); ++p) {
      if ((descriptions[p].role == Role::implicit_solver) != implicit) continue;
      const auto own = nodes_of(descriptions[p], p);
      nodes.insert(nodes.end(), own.begin(), own.end());
    }
  }
  std::vector<std::vector<int>> shared(descriptions.size());  // of each participant, per own node
  for (std::size_t p = 0; p < descriptions.size(); ++p) {
    require(
        descriptions[p].components == descriptions[0].components,
        fmt::format("participant '{}' has {} components per node, participant '{}' has {}", descriptions[p].participant,
                    descriptions[p].components, descriptions[0].participant, descriptions[0].components));
    components_ = static_cast<int>(descriptions[p].components);
    shared[p].resize(static_cast<std::size_t>(descriptions[p].interface_position_m.rows));
  }
  extent_m_ = extent(nodes);
  Matcher matcher(same_place * extent_m_);
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < nodes.size(); ++i) groups[matcher.place(nodes[i], nodes, groups)].push_back(i);
  mass_kg_.assign(groups.size(), 0.0);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    check_owners(groups[g], nodes);
    std::stable_sort(groups[g].begin(), groups[g].end(),
                     [&](std::size_t a, std::size_t b) { return nodes[a].participant < nodes[b].participant; });
    for (const std::size_t i : groups[g]) {
      mass_kg_[g] += nodes[i].mass_kg;
      shared[nodes[i].participant][nodes[i].row] = static_cast<int>(g);
    }
  }
  for (auto& own : shared) rows_.emplace_back(std::move(own), components_);
}

}  // namespace ricochet::coupler
