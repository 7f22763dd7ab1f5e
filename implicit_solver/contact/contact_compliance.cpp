// The motion by forces of the contact's pairs, found in the way that the size of the contact asks for.
#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "implicit_solver/contact/implicit_contact.hpp"
#include "implicit_solver/contact/kept_columns.hpp"

namespace ricochet::implicit_solver {

using solver::BodyState;
using solver::RowEntry;

namespace {
/// Rows written by a mortar have many degrees of freedom each, too many for the root, while the compliance of so many
/// rows may be small enough for a solve each.
constexpr int most_columns = 800;
/// Columns of S^-1 that are kept, and the numbers in them [256 MB]. Each is a solve, while a window of friction takes
/// some thirty of them: those of three hundred forces, of some eight hundred degrees of freedom, pay within thirty
/// windows.
constexpr Eigen::Index most_kept_columns = 2400, most_kept_numbers = 32'000'000;
}  // namespace

void ImplicitContact::prepare(const Eigen::MatrixXd& root_inverse, double dt) {
  dt_ = dt;
  response_.turn = {};
  write_rows();
  response_.dense = root_inverse;
  start(compliance_of_rows());
  if (!other_rows_come()) response_.dense.resize(0, 0);
}

void ImplicitContact::turn(const std::vector<Eigen::Matrix3d>& by, const std::vector<BodyState>& states) {
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < root_dofs_.size(); ++i) {
    const auto [part, dof] = local(root_dofs_[i]);
    const int row = dof % surface_.components, first = root_dofs_[i] - row;
    for (int column = 0; column < surface_.components; ++column) {
      const int root = root_of_dof_[static_cast<std::size_t>(first + column)];
      const double entry = by[static_cast<std::size_t>(part)](row, column);
      if (root >= 0 && entry != 0.0) entries.emplace_back(static_cast<int>(i), root, entry);
    }
  }
  response_.turn.resize(std::ssize(root_dofs_), std::ssize(root_dofs_));
  response_.turn.setFromTriplets(entries.begin(), entries.end());
  take_new_pairs(states);
}

void ImplicitContact::write_rows() {
  const auto root = [this](const RowEntry& e) { return root_of_dof_[static_cast<std::size_t>(combined(e))]; };
  response_.rows = solver::matrix_of_rows(surface_.pairs, directions(), std::ssize(root_dofs_), root);
}

/// kappa dt^2/4 G S^-1 G^T, with the few entries that a row has.
solver::Compliance ImplicitContact::compliance_of_rows() const {
  using Sparse = solver::Compliance::Sparse;
  const bool turned = response_.turn.size() > 0;
  const Sparse of_factor = turned ? Sparse(response_.rows * response_.turn) : Sparse();
  const Sparse& rows = turned ? of_factor : response_.rows;
  const double scale = kappa() * 0.25 * dt_ * dt_;
  if (response_.near.size() > 0) {
    Sparse compliance = rows * response_.near * Sparse(rows.transpose());
    compliance *= scale;
    return compliance;
  }
  Eigen::MatrixXd compliance(rows.rows(), rows.rows());
  Eigen::VectorXd moved(rows.cols());
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    moved.setZero();
    for (Sparse::InnerIterator it(rows, row); it; ++it) moved += scale * it.value() * response_.dense.col(it.col());
    compliance.col(row).noalias() = rows * moved;
  }
  return compliance;
}

bool ImplicitContact::has_columns() const { return !other_rows_come() && rows() <= most_columns; }

bool ImplicitContact::moves_what_is_near(const std::vector<BodyState>& states, const SolveFor& solve, int most_solves) {
  const int most = has_columns() ? std::min(most_solves, rows()) : most_solves;
  response_.groups = near_groups(root_nodes(states), most, solve);
  return response_.groups.has_value();
}

void ImplicitContact::prepare(const std::vector<BodyState>& states, SolveFor solve, double dt) {
  dt_ = dt;
  response_.turn = {};
  write_rows();
  auto inverse = response_.groups ? near_inverse(root_nodes(states), *response_.groups, solve) : std::nullopt;
  if (inverse) {
    response_.near.swap(*inverse);
    start(compliance_of_rows());
    if (!other_rows_come()) response_.near = {};
    return;
  }
  const double scale = kappa() * 0.25 * dt * dt;
  const auto of_rows = [this, scale](SolveFor of_dofs) {
    return [this, scale, of_dofs = std::move(of_dofs), forces = Eigen::VectorXd(), motion = Eigen::VectorXd()](
               const Eigen::VectorXd& x, Eigen::VectorXd& y) mutable {
      forces.noalias() = response_.rows.transpose() * x;
      forces *= scale;
      if (response_.turn.size() > 0) forces = (response_.turn.transpose() * forces).eval();
      of_dofs(forces, motion);
      if (response_.turn.size() > 0) motion = (response_.turn * motion).eval();
      y.noalias() = response_.rows * motion;
    };
  };
  if (has_columns()) {
    response_.product = of_rows(std::move(solve));
    start(columns_of_products(rows()));
    return;
  }
  const auto dofs = std::ssize(root_dofs_),
             most = std::min(most_kept_columns, most_kept_numbers / std::max(dofs, std::ptrdiff_t{1}));
  // The columns of S^-1 outlive the rows, and all copies of the product share them. Those of the pairs belong to one
  // set of rows: a copy that new rows take begins without any.
  const auto kept = std::make_shared<KeptColumns>(std::move(solve), most / 2, most);
  response_.product =
      KeptColumns(of_rows([kept](const auto& forces, auto& motion) { (*kept)(forces, motion); }), most / 8, most / 4);
  start({response_.product, bound_of_couplings(states)});
}

/// Part and its own number of a combined one.
std::pair<int, int> ImplicitContact::local(int dof) const {
  const auto part = std::upper_bound(offsets_.begin(), offsets_.end(), dof) - offsets_.begin() - 1;
  return {static_cast<int>(part), dof - offsets_[static_cast<std::size_t>(part)]};
}

/// The nodes of the root dofs.
std::vector<NearNode> ImplicitContact::root_nodes(const std::vector<BodyState>& states) const {
  std::map<std::pair<int, int>, NearNode> nodes;
  for (std::size_t i = 0; i < root_dofs_.size(); ++i) {
    const auto [part, dof] = local(root_dofs_[i]);
    const int node = dof / surface_.components;
    const auto& positions = states[static_cast<std::size_t>(part)].part.mesh.position;
    NearNode& found =
        nodes.try_emplace({part, node}, NearNode{positions[static_cast<std::size_t>(node)], part, {}}).first->second;
    found.dofs.push_back(static_cast<int>(i));
  }
  std::vector<NearNode> listed;
  for (auto& [key, node] : nodes) listed.push_back(std::move(node));
  return listed;
}

Eigen::MatrixXd ImplicitContact::columns_of_products(Eigen::Index size) const {
  Eigen::MatrixXd columns(size, size);
  Eigen::VectorXd column(size);
  for (Eigen::Index j = 0; j < size; ++j) {
    response_.product(Eigen::VectorXd::Unit(size, j), column);
    columns.col(j) = column;
  }
  return 0.5 * (columns + columns.transpose());
}

/// No less than the compliance, on its diagonal: the sums of magnitudes in the rows of N M^-1 N^T.
Eigen::VectorXd ImplicitContact::bound_of_couplings(const std::vector<BodyState>& states) const {
  Eigen::VectorXd inverse(std::ssize(root_dofs_));
  for (std::size_t i = 0; i < root_dofs_.size(); ++i) {
    const auto [part, dof] = local(root_dofs_[i]);
    inverse[static_cast<Eigen::Index>(i)] = states[static_cast<std::size_t>(part)].inverse_mass[dof];
  }
  const solver::Compliance::Sparse magnitude = response_.rows.cwiseAbs();
  const auto n = static_cast<Eigen::Index>(pairs());
  Eigen::VectorXd bound(magnitude.rows());
  for (Eigen::Index d = 0; d < directions(); ++d) {
    Eigen::VectorXd forces = Eigen::VectorXd::Zero(magnitude.rows());
    forces.segment(d * n, n).setOnes();
    const Eigen::VectorXd moved = magnitude * inverse.cwiseProduct(magnitude.transpose() * forces);
    bound.segment(d * n, n) = kappa() * 0.25 * dt_ * dt_ * moved.segment(d * n, n);
  }
  return bound;
}

}  // namespace ricochet::implicit_solver
