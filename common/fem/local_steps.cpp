#include "common/fem/local_steps.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::fem {
namespace {

/// Where a level takes two steps, a force that is held moves its stiffest mode by no less than some nu/2 of what it
/// would at rest: with 0.01 contact forces of neighbouring nodes differ by 14 % too much (rounded striker), with 0.2
/// they do not, and a step of a level is 0.52 of the one before.
constexpr double nu = 0.2;
/// Share of what the steps of a level bear, in lambda tau^2: at 1 its stiffest mode would not answer to a force at all.
constexpr double level_share = 0.95;
constexpr double raise = 1.1;
constexpr int most_levels = 20;
constexpr double shortening_squared = [] {
  constexpr double d = 1.0 + nu / 4.0;
  return (2.0 * d * d - 1.0) / (4.0 * d * d);  // tau_l^2 / tau_{l-1}^2
}();

/// Per node: the largest sum_j |K_ij|/m_i of its free degrees of freedom, over free j [1/s^2].
Eigen::VectorXd stiffness_of_nodes(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, int components) {
  Eigen::VectorXd of_node = Eigen::VectorXd::Zero(inverse_mass.size() / components);
  for (int row = 0; row < stiffness.outerSize(); ++row) {
    double sum = 0.0;
    for (SparseMatrix::InnerIterator it(stiffness, row); it; ++it)
      if (inverse_mass[it.col()] > 0.0) sum += std::abs(it.value());
    double& largest = of_node[row / components];
    largest = std::max(largest, sum * inverse_mass[row]);
  }
  return of_node;
}

/// Marks the neighbours of marked nodes, too: K is symmetric, so that their own rows name them.
std::vector<bool> with_a_layer(const SparseMatrix& stiffness, int components, const std::vector<bool>& marked) {
  std::vector<bool> more = marked;
  for (int row = 0; row < stiffness.outerSize(); ++row) {
    if (!marked[static_cast<std::size_t>(row / components)]) continue;
    for (SparseMatrix::InnerIterator it(stiffness, row); it; ++it)
      more[static_cast<std::size_t>(it.col() / components)] = true;
  }
  return more;
}

}  // namespace

LocalSteps::LocalSteps(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, int components,
                       double window_s, Levels levels, Nodes nodes)
    : components_(components),
      nodes_(std::move(nodes)),
      longest_window_s_(window_s),
      level_of_node_(static_cast<std::size_t>(inverse_mass.size() / components), 0) {
  Eigen::VectorXd of_node = stiffness_of_nodes(stiffness, inverse_mass, components);
  for (std::size_t n = 0; n < level_of_node_.size(); ++n)
    if (takes_none(n) || (!nodes_.may_be_stiff.empty() && !nodes_.may_be_stiff[n]))
      of_node[static_cast<Eigen::Index>(n)] = 0.0;
  const double most = 4.0 / (window_s * window_s);
  if (of_node.size() == 0 || of_node.maxCoeff() <= most) return;
  Eigen::VectorXd mass = Eigen::VectorXd::Ones(of_node.size());
  std::vector<bool> fixed(static_cast<std::size_t>(inverse_mass.size()));
  for (Eigen::Index dof = 0; dof < inverse_mass.size(); ++dof) {
    fixed[static_cast<std::size_t>(dof)] = inverse_mass[dof] == 0.0;
    if (inverse_mass[dof] > 0.0) mass[dof / components] = 1.0 / inverse_mass[dof];
  }
  const StiffnessProduct product(stiffness, components);
  const auto times = [&product](const Eigen::VectorXd& u, Eigen::VectorXd& force) { product.multiply(u, force); };
  const double largest = max_frequency_squared(times, mass, components, fixed, 1e-4, 1e-3);
  if (largest <= most) return;
  const double softest = (of_node.array() > 0.0).select(of_node, of_node.maxCoeff()).minCoeff();
  for (double scale = std::min(1.0, largest / of_node.maxCoeff());; scale = std::min(1.0, raise * scale)) {
    set_levels(stiffness, inverse_mass, window_s, scale * of_node);
    longest_window_s_ = 2.0 / std::sqrt(scale * softest);
    if (levels == Levels::expected || bears(product, mass, fixed, window_s)) return;
    if (scale == 1.0) throw SolverError("local steps: no levels were found that bear the window");
  }
}

void LocalSteps::set_levels(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, double window_s,
                            const Eigen::VectorXd& stiffness_of_node) {
  levels_.clear();
  reached_.clear();
  std::fill(level_of_node_.begin(), level_of_node_.end(), 0);
  std::vector<int> numbered(static_cast<std::size_t>(inverse_mass.size()));  // dofs as the level before numbers them
  std::iota(numbered.begin(), numbered.end(), 0);
  double bearable = 4.0 / (window_s * window_s), tau_squared = window_s * window_s;
  for (int level = 1; stiffness_of_node.maxCoeff() > bearable; ++level) {
    if (level > most_levels) throw SolverError("local steps: a window takes more than 2^20 of the smallest steps");
    std::vector<bool> marked(level_of_node_.size());
    for (std::size_t n = 0; n < marked.size(); ++n)
      marked[n] = stiffness_of_node[static_cast<Eigen::Index>(n)] > bearable;
    marked = with_a_layer(stiffness, components_, marked);
    for (std::size_t n = 0; n < marked.size(); ++n)
      if (marked[n] && !takes_none(n)) level_of_node_[n] = level;
    tau_squared *= shortening_squared;
    add_level(stiffness, inverse_mass, tau_squared / 4.0, level, numbered);
    bearable = level_share * 4.0 / tau_squared;
  }
}

void LocalSteps::add_level(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, double kappa, int level,
                           std::vector<int>& numbered) {
  std::vector<bool> inside(level_of_node_.size());
  for (std::size_t n = 0; n < inside.size(); ++n) inside[n] = level_of_node_[n] >= level;
  const std::vector<bool> reached = with_a_layer(stiffness, components_, inside);
  Level added;
  std::vector<int> dofs, own(numbered.size(), -1);
  for (int dof = 0; dof < static_cast<int>(numbered.size()); ++dof) {
    if (!reached[static_cast<std::size_t>(dof / components_)]) continue;
    own[static_cast<std::size_t>(dof)] = static_cast<int>(dofs.size());
    added.of_before.push_back(numbered[static_cast<std::size_t>(dof)]);
    dofs.push_back(dof);
    if (level == 1 && dof % components_ == 0) reached_.push_back(dof / components_);
  }
  const auto size = static_cast<Eigen::Index>(dofs.size());
  std::vector<Eigen::Triplet<double>> entries;
  added.kappa.setZero(size);
  for (int i = 0; i < static_cast<int>(size); ++i) {
    const int dof = dofs[static_cast<std::size_t>(i)];
    if (inside[static_cast<std::size_t>(dof / components_)]) added.kappa[i] = kappa * inverse_mass[dof];
    for (SparseMatrix::InnerIterator it(stiffness, dof); it; ++it)
      if (const int column = own[static_cast<std::size_t>(it.col())]; column >= 0)
        entries.emplace_back(i, column, it.value());
  }
  SparseMatrix rows(size, size);
  rows.setFromTriplets(entries.begin(), entries.end());
  added.stiffness = StiffnessProduct(rows, components_);
  for (auto* vector : {&added.force, &added.moved, &added.pull}) vector->setZero(size);
  levels_.push_back(std::move(added));
  numbered = std::move(own);
}

/// Neither grows a mode of K~ within a window, nor is one pushed away from where it is: 0 <= lambda dt^2 <= 4.
bool LocalSteps::bears(const StiffnessProduct& stiffness, const Eigen::VectorXd& mass, const std::vector<bool>& fixed,
                       double window_s) {
  constexpr int products = 30;
  const double most = 4.0 / (window_s * window_s);
  const auto times = [&](const Eigen::VectorXd& u, Eigen::VectorXd& force) {
    stiffness.multiply(u, force);
    spread(force);
  };
  try {
    if (max_frequency_squared(times, mass, components_, fixed, 1e-3) > most) return false;
  } catch (const SolverError&) {
    return false;  // so far from it that numbers overflow
  }
  const auto below = [&](const Eigen::VectorXd& u, Eigen::VectorXd& force) {
    times(u, force);
    for (Eigen::Index i = 0; i < u.size(); ++i) force[i] = most * mass[i / components_] * u[i] - force[i];
  };
  return frequency_squared_at_least(below, mass, components_, fixed, products) <= most * (1.0 + 1e-9);
}

void LocalSteps::renumber(const std::vector<int>& place, int nodes) {
  const auto number = [&](int node) { return place[static_cast<std::size_t>(node)]; };
  if (!levels_.empty())
    for (int& dof : levels_.front().of_before) dof = number(dof / components_) * components_ + dof % components_;
  for (int& node : reached_) node = number(node);
  std::vector<int> level_of_node(static_cast<std::size_t>(nodes), 0);
  for (std::size_t node = 0; node < level_of_node_.size(); ++node)
    if (place[node] >= 0) level_of_node[static_cast<std::size_t>(place[node])] = level_of_node_[node];
  level_of_node_ = std::move(level_of_node);
}

void LocalSteps::compute_with(const std::shared_ptr<Parallel>& parallel) {
  for (Level& level : levels_) level.stiffness.compute_with(parallel);
}

void LocalSteps::spread(Eigen::VectorXd& force) {
  if (any()) step(0, force);
}

/// Steps with `force` as the level before numbers it, or as the part does.
void LocalSteps::step(std::size_t index, Eigen::VectorXd& force) {
  Level& level = levels_[index];
  const auto size = static_cast<Eigen::Index>(level.of_before.size());
  for (Eigen::Index i = 0; i < size; ++i) level.force[i] = force[level.of_before[static_cast<std::size_t>(i)]];
  if (index + 1 < levels_.size()) {
    level.moved = level.force;
    step(index + 1, level.moved);
    level.moved.array() *= level.kappa.array();
  } else {
    level.moved = level.kappa.cwiseProduct(level.force);
  }
  level.stiffness.multiply(level.moved, level.pull);
  level.force -= level.pull;
  if (index + 1 < levels_.size()) step(index + 1, level.force);
  for (Eigen::Index i = 0; i < size; ++i) force[level.of_before[static_cast<std::size_t>(i)]] = level.force[i];
}

std::vector<int> LocalSteps::nodes_by_level() const {
  std::vector<int> nodes(levels_.size() + 1, 0);
  for (const int level : level_of_node_) ++nodes[static_cast<std::size_t>(level)];
  return nodes;
}

double LocalSteps::extra_rows() const {
  double rows = 0.0, times = 1.0;
  for (const Level& level : levels_) {
    rows += times * static_cast<double>(level.of_before.size());
    times *= 2.0;
  }
  return rows / (static_cast<double>(level_of_node_.size()) * components_);
}

}  // namespace ricochet::fem
