#include "coupler/protocols/probe_groups.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace ricochet::coupler {
namespace {

using Places = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr Eigen::Index samples = 6;  ///< nodes at which the reach is measured
constexpr double moved_share = 1e-16, symmetric_share = 1e-12;

struct Interface {
  Places place;
  int components = 1;

  [[nodiscard]] Eigen::Index nodes() const { return place.rows(); }
  [[nodiscard]] double distance(Eigen::Index a, Eigen::Index b) const { return (place.row(a) - place.row(b)).norm(); }
};

/// Distance of every node to the nearest other one [m].
std::vector<double> spacings(const Interface& interface) {
  std::vector<double> spacing;
  for (Eigen::Index a = 0; a < interface.nodes(); ++a) {
    double nearest = std::numeric_limits<double>::infinity();
    for (Eigen::Index b = 0; b < interface.nodes(); ++b)
      if (b != a) nearest = std::min(nearest, interface.distance(a, b));
    spacing.push_back(nearest);
  }
  return spacing;
}

/// Half of them with the largest spacing, half spread over the interface.
std::vector<Eigen::Index> sampled(const std::vector<double>& spacing) {
  std::vector<Eigen::Index> nodes(spacing.size());
  std::iota(nodes.begin(), nodes.end(), 0);
  std::stable_sort(nodes.begin(), nodes.end(), [&](Eigen::Index a, Eigen::Index b) {
    return spacing[static_cast<std::size_t>(a)] > spacing[static_cast<std::size_t>(b)];
  });
  nodes.resize(samples / 2);
  const auto all = static_cast<Eigen::Index>(spacing.size());
  for (Eigen::Index i = 0; i < samples / 2; ++i) nodes.push_back((2 * i + 1) * all / samples);
  return nodes;
}

/// How far the answer to pushes of one node reaches [m].
double reach_of(const Interface& interface, Eigen::Index node, const std::vector<double>& probes,
                const ChangeOfAnswer& answer) {
  double reach_m = 0.0;
  for (int c = 0; c < interface.components; ++c) {
    const Eigen::Index dof = node * interface.components + c;
    Eigen::VectorXd push = Eigen::VectorXd::Zero(interface.nodes() * interface.components);
    push[dof] = probes[static_cast<std::size_t>(dof)];
    const Eigen::VectorXd moved = answer(push).cwiseAbs();
    const double counts = moved_share * moved.maxCoeff();
    for (Eigen::Index i = 0; i < moved.size(); ++i)
      if (moved[i] > counts) reach_m = std::max(reach_m, interface.distance(node, i / interface.components));
  }
  return reach_m;
}

/// Per node the smallest number that no node before it has within `apart_m`.
std::vector<int> colours(const Interface& interface, double apart_m) {
  std::vector<int> colour;
  for (Eigen::Index a = 0; a < interface.nodes(); ++a) {
    std::vector<bool> taken(static_cast<std::size_t>(a) + 1, false);
    for (Eigen::Index b = 0; b < a; ++b)
      if (interface.distance(a, b) <= apart_m)
        taken[static_cast<std::size_t>(colour[static_cast<std::size_t>(b)])] = true;
    colour.push_back(static_cast<int>(std::find(taken.begin(), taken.end(), false) - taken.begin()));
  }
  return colour;
}

/// Puts the answer to one component of a group's nodes into their columns; false if something else moves.
bool take_columns(const Interface& interface, const std::vector<Eigen::Index>& group, int component, double reach_m,
                  const std::vector<double>& probes, const ChangeOfAnswer& answer, Eigen::MatrixXd& matrix) {
  const int components = interface.components;
  Eigen::VectorXd push = Eigen::VectorXd::Zero(matrix.rows());
  for (const Eigen::Index node : group) {
    const Eigen::Index dof = node * components + component;
    push[dof] = probes[static_cast<std::size_t>(dof)];
  }
  Eigen::VectorXd moved = answer(push);
  const double counts = moved_share * moved.cwiseAbs().maxCoeff();
  for (const Eigen::Index node : group) {
    for (Eigen::Index other = 0; other < interface.nodes(); ++other) {
      if (interface.distance(node, other) > reach_m) continue;
      const Eigen::Index dof = node * components + component;
      matrix.col(dof).segment(other * components, components) =
          moved.segment(other * components, components) / push[dof];
      moved.segment(other * components, components).setZero();
    }
  }
  return moved.cwiseAbs().maxCoeff() <= counts;
}

Interface interface_of(const Link& link, std::size_t inputs) {
  Interface interface;
  const auto& position = link.description().interface_position_m;
  interface.components = link.rows().components();
  if (static_cast<std::size_t>(position.rows) * static_cast<std::size_t>(interface.components) != inputs)
    return interface;
  interface.place = Eigen::Map<const Places>(position.data.data(), position.rows, position.columns);
  return interface;
}

}  // namespace

std::optional<Eigen::MatrixXd> response_by_groups(const Link& link, const std::vector<double>& probes,
                                                  const ChangeOfAnswer& answer) {
  const Interface interface = interface_of(link, probes.size());
  if (interface.nodes() <= 2 * samples) return std::nullopt;
  const std::vector<double> spacing = spacings(interface);
  const double largest_m = *std::max_element(spacing.begin(), spacing.end());
  double reach_m = largest_m;
  for (const Eigen::Index node : sampled(spacing))
    reach_m = std::max(reach_m, reach_of(interface, node, probes, answer));
  reach_m *= 1.0 + 1e-6;
  const std::vector<int> colour = colours(interface, 2.0 * reach_m + largest_m);
  const int groups = *std::max_element(colour.begin(), colour.end()) + 1;
  if (groups + samples >= interface.nodes()) return std::nullopt;
  const auto size = static_cast<Eigen::Index>(probes.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (int g = 0; g < groups; ++g) {
    std::vector<Eigen::Index> group;
    for (Eigen::Index node = 0; node < interface.nodes(); ++node)
      if (colour[static_cast<std::size_t>(node)] == g) group.push_back(node);
    for (int c = 0; c < interface.components; ++c)
      if (!take_columns(interface, group, c, reach_m, probes, answer, matrix)) return std::nullopt;
  }
  const double difference = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  if (difference > symmetric_share * matrix.cwiseAbs().maxCoeff()) return std::nullopt;
  return matrix;
}

}  // namespace ricochet::coupler
