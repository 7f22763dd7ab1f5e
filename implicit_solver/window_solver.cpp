#include "implicit_solver/window_solver.hpp"

#include <algorithm>

#include "common/contact/compliance.hpp"

namespace ricochet::implicit_solver {

namespace {
/// With the shared nodes in the root most of a solve is done before the link's force is there, but every window
/// multiplies by the dense inverse of the root. That pays while it has at most so many entries per entry of the
/// operator. Measured on the rounded striker: 312 root unknowns (the limit there) break even, with 998 the implicit
/// side takes four times as long.
constexpr std::size_t root_entries_per_entry = 2;
/// Up to so many contact dofs are in the root, whose dense inverse costs their cube to find and their square to keep
/// and to use. More of them are eliminated with all others if their block of A^-1 has few entries; then what contact
/// forces add to the motion is another solve of the whole operator. Measured on flat cylinders: with 600 a hybrid
/// window costs the same either way, finding the inverse three times the rest of the set-up with 800.
constexpr std::size_t most_contact_dofs_in_root = 800;
/// Where forces move what is far, up to so many, 290 MB, and so many entries of their inverse per entry of the
/// operator: the only other way is a solve of the whole operator for every product. Measured on solids that stick: with
/// ten entries per entry finding the inverse takes as long as forty windows by products.
constexpr std::size_t most_coupled_dofs_in_root = 6000, coupled_entries_per_entry = 4;

/// Solves that set-up may take to find few entries of A^-1, so that no window needs any for the contact problem: worth
/// it after a tenth as many windows, since a window without them takes some ten.
constexpr int most_solves = 800, most_solves_if_it_fits = 200;

/// Motion of `dofs` by forces on them: conjugate gradients on A x = f, x and f zero where not active, from whose kth
/// iterate nothing is moved that is more than k elements away (Hestenes, Stiefel 1952), preconditioned by the diagonal.
class ProductSolve {
 public:
  ProductSolve(const fem::SparseMatrix& a, const std::vector<bool>& active, const std::vector<int>& dofs)
      : a_(a), dofs_(dofs), scale_(a.diagonal().cwiseInverse()) {
    for (Eigen::Index i = 0; i < scale_.size(); ++i)
      if (!active[static_cast<std::size_t>(i)]) scale_[i] = 0.0;
  }

  void operator()(const Eigen::VectorXd& forces, Eigen::VectorXd& motion) const {
    constexpr int most_products = 100;
    constexpr double settled = 1e-17;
    Eigen::VectorXd r = Eigen::VectorXd::Zero(a_.rows()), x = r;
    for (Eigen::Index i = 0; i < forces.size(); ++i) r[dofs_[static_cast<std::size_t>(i)]] = forces[i];
    Eigen::VectorXd z = scale_.cwiseProduct(r), p = z, q;
    double rz = r.dot(z);
    const double enough = settled * settled * rz;
    for (int k = 0; k < most_products && rz > enough; ++k) {
      q.noalias() = a_ * p;
      const double alpha = rz / p.dot(q), before = rz;
      x += alpha * p;
      r -= alpha * q;
      z = scale_.cwiseProduct(r);
      rz = r.dot(z);
      p = z + rz / before * p;
    }
    motion.resize(forces.size());
    for (Eigen::Index i = 0; i < forces.size(); ++i) motion[i] = x[dofs_[static_cast<std::size_t>(i)]];
  }

 private:
  const fem::SparseMatrix& a_;
  const std::vector<int>& dofs_;
  Eigen::VectorXd scale_;  ///< inverse of the diagonal; 0 where not active
};
}  // namespace

WindowSolver::WindowSolver(const CombinedParts& parts, ImplicitContact* contact,
                           const Eigen::MatrixXd& interface_stiffness, double dt, participant::Heartbeat* heart)
    : parts_(parts), contact_(contact), interface_stiffness_(interface_stiffness), dt_(dt) {
  linearise(parts_.displacement(), heart);
}

/// Adds scale S to the shared dofs of a matrix.
void WindowSolver::add_interface_stiffness(double scale, fem::SparseMatrix& a) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < interface_stiffness_.rows(); ++i) {
    for (Eigen::Index j = 0; j < interface_stiffness_.cols(); ++j) {
      const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
      if (interface_stiffness_(i, j) != 0.0) {
        entries.emplace_back(parts_.shared_dofs[row], parts_.shared_dofs[column], scale * interface_stiffness_(i, j));
      }
    }
  }
  fem::SparseMatrix s(a.rows(), a.cols());
  s.setFromTriplets(entries.begin(), entries.end());
  a += s;
}

/// A = M + dt/2 C + dt^2/4 (K_T + S), and which dofs are free.
fem::SparseMatrix WindowSolver::assemble(const Eigen::VectorXd& u, std::vector<bool>& active) {
  const double dt = dt_;
  tangents_ = parts_.tangents(u);
  stiffest_n_m_.clear();
  for (const fem::SparseMatrix* tangent : tangents_)
    stiffest_n_m_.push_back(tangent->rows() > 0 ? tangent->diagonal().maxCoeff() : 0.0);
  fem::SparseMatrix a = parts_.block_diagonal(tangents_);
  a *= 0.25 * dt * dt;
  active.resize(static_cast<std::size_t>(a.rows()));
  Eigen::VectorXd mass(a.rows());
  for (std::size_t b = 0; b < parts_.states.size(); ++b) {
    parts_.segment(mass, b) = parts_.states[b].mass;
    for (const auto& d : parts_.states[b].dashpots) mass[parts_.offsets[b] + d.dof] += 0.5 * dt * d.coefficient_kg_s;
    for (int dof = 0; dof < parts_.states[b].part.dofs(); ++dof) {
      active[static_cast<std::size_t>(parts_.offsets[b] + dof)] = parts_.states[b].free[static_cast<std::size_t>(dof)];
    }
  }
  a += fem::SparseMatrix(mass.asDiagonal());
  if (interface_stiffness_.size() > 0) add_interface_stiffness(0.25 * dt * dt, a);
  return a;
}

bool WindowSolver::contact_belongs_in_root(const fem::SparseMatrix& a, const std::vector<bool>& active) {
  if (root_.size() <= most_contact_dofs_in_root || contact_->massless()) return true;
  const std::size_t roots = root_.size();
  const bool fits = roots <= most_coupled_dofs_in_root &&
                    roots * roots <= coupled_entries_per_entry * static_cast<std::size_t>(a.nonZeros());
  const bool sparse = contact_->moves_what_is_near(parts_.states, ProductSolve(a, active, root_),
                                                   fits ? most_solves_if_it_fits : most_solves);
  return fits && !sparse;
}

void WindowSolver::choose_root(const fem::SparseMatrix& a, const std::vector<bool>& active) {
  root_ = contact_ ? contact_->root_dofs() : std::vector<int>{};
  if (!contact_in_root_) contact_in_root_ = contact_belongs_in_root(a, active);
  if (!*contact_in_root_) root_.clear();
  const std::size_t roots = root_.size() + parts_.shared_dofs.size();
  link_in_root_ = *contact_in_root_ && roots * roots <= root_entries_per_entry * static_cast<std::size_t>(a.nonZeros());
  shared_roots_.clear();
  for (const int dof : link_in_root_ ? parts_.shared_dofs : std::vector<int>{}) {
    const auto found = std::find(root_.begin(), root_.end(), dof);
    if (!active[static_cast<std::size_t>(dof)]) continue;
    shared_roots_.emplace_back(dof, found - root_.begin());
    if (found == root_.end()) root_.push_back(dof);
  }
}

void WindowSolver::linearise(const Eigen::VectorXd& u, participant::Heartbeat* heart) {
  if (!parts_.keep_tangents()) linearised_at_ = u;
  std::vector<bool> active;
  fem::SparseMatrix a = assemble(u, active);
  choose_root(a, active);
  factor_.emplace(parts_, parts_.rotations(u), std::move(a), active, root_, heart);
  if (!contact_) return;
  if (heart) heart->begin("preparing the contact");
  prepare_contact();
}

/// contact_increment_ = A^-1 of forces on the contact's root dofs.
template <class Factor>
void WindowSolver::move_by(const Eigen::VectorXd& forces, Factor& factor) {
  for (Eigen::Index i = 0; i < forces.size(); ++i)
    contact_force_[contact_->root_dofs()[static_cast<std::size_t>(i)]] = forces[i];
  factor.forward(contact_force_);
  factor.backward(root_increment_, contact_increment_);
}

void WindowSolver::prepare_contact() {
  const auto size = static_cast<Eigen::Index>(contact_->root_dofs().size());
  if (*contact_in_root_) {
    contact_->prepare(factor_->root_inverse().topLeftCorner(size, size), dt_);
    return;
  }
  contact_force_.setZero(parts_.dofs());
  contact_increment_.setZero(parts_.dofs());
  const auto solve = [this](const Eigen::VectorXd& forces, Eigen::VectorXd& motion) {
    move_by(forces, factor_->as_factored());
    motion.resize(forces.size());
    for (Eigen::Index i = 0; i < forces.size(); ++i)
      motion[i] = contact_increment_[contact_->root_dofs()[static_cast<std::size_t>(i)]];
  };
  contact_->prepare(parts_.states, solve, dt_);
}

void WindowSolver::turn(const std::vector<Eigen::Matrix3d>& directions) {
  factor_->turn(directions);
  if (contact_) contact_->turn(factor_->turned_by(), parts_.states);
}

void WindowSolver::subtract_moved(std::size_t part, int dof, double du, Eigen::VectorXd& b) const {
  const double quarter = 0.25 * dt_ * dt_;
  for (fem::SparseMatrix::InnerIterator it(*tangents_[part], dof); it; ++it)
    b[parts_.offsets[part] + it.col()] -= quarter * it.value() * du;
}

void WindowSolver::eliminate(const Eigen::VectorXd& b) {
  if (link_in_root_) factor_->forward(b);
}

void WindowSolver::solve(const Eigen::VectorXd& b, const Eigen::VectorXd& link_before, const Eigen::VectorXd& link,
                         const Eigen::VectorXd* from, Eigen::VectorXd& increment) {
  const double quarter = 0.25 * dt_ * dt_;
  if (link_in_root_) {
    root_rhs_ = factor_->root_rhs();
    for (const auto& [dof, root] : shared_roots_) root_rhs_[root] -= quarter * (link[dof] - link_before[dof]);
  } else {
    b_with_link_ = b;
    for (const int dof : parts_.shared_dofs) b_with_link_[dof] -= quarter * (link[dof] - link_before[dof]);
    factor_->forward(b_with_link_);
    root_rhs_ = factor_->root_rhs();
  }
  if (from) begin_from(*from);
  find_increment(from ? &from_ : nullptr, false, increment);
}

/// Degrees of freedom that are no unknowns of the operator stay as they are.
void WindowSolver::begin_from(const Eigen::VectorXd& from) {
  from_ = from;
  for (const int dof : factor_->inactive()) from_[dof] = 0.0;
}

void WindowSolver::improve(const Eigen::VectorXd& b, Eigen::VectorXd& increment) {
  begin_from(increment);
  factor_->forward(b);
  root_rhs_ = factor_->root_rhs();
  find_increment(&from_, true, increment);
}

/// The increment without contact forces first, then what they add to it.
void WindowSolver::solve_contact_outside_root(const Eigen::VectorXd* from, bool again, Eigen::VectorXd& increment) {
  factor_->backward(root_increment_, increment);
  if (from) increment += *from;
  contact_->solve(parts_.states, increment, again);
  if (!contact_->any_force()) return;
  move_by(contact_->root_force(), *factor_);
  increment.noalias() += (contact_->kappa() * 0.25 * dt_ * dt_) * contact_increment_;
}

/// Completes a solve whose root has its right-hand side; the increment is counted from `from`, if that is given.
/// `again`: see ImplicitContact::solve.
void WindowSolver::find_increment(const Eigen::VectorXd* from, bool again, Eigen::VectorXd& increment) {
  factor_->solve_root(root_rhs_, root_increment_);
  if (!*contact_in_root_) {
    solve_contact_outside_root(from, again, increment);
    return;
  }
  if (contact_) {
    const auto& root = contact_->root_dofs();
    for (std::size_t i = 0; i < root.size(); ++i) {
      increment[root[i]] = root_increment_[static_cast<Eigen::Index>(i)];
      if (from) increment[root[i]] += (*from)[root[i]];
    }
    contact_->solve(parts_.states, increment, again);
    const double scale = contact_->kappa() * 0.25 * dt_ * dt_;
    root_force_ = scale * contact_->root_force();
    factor_->add_root_motion(root_force_, root_increment_);
  }
  factor_->backward(root_increment_, increment);
  if (from) increment += *from;
}

}  // namespace ricochet::implicit_solver
