#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCholesky>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/body_state.hpp"
#include "common/contact/contact_surface.hpp"
#include "common/contact/root_problem.hpp"

namespace ricochet::solver {

/// Contact nodes without mass along the contact's normal (Khenous, Laborde, Renard 2008; Doyen, Ern, Piperno 2011): the
/// mass of each goes in equal shares to its neighbours one layer of elements inwards. No velocity of such a node can
/// jump, so that an impact costs no energy, and its force is that of the elements behind it, without the inertia of a
/// lumped node.
///
/// Under an explicit integration their displacement u_c follows from that of the others: with the external force f,
///   K_cc u_c = f_c - K_ci u_i + N^T r,   gap = g0 + N u >= 0,   r >= 0,   r . gap = 0
/// (`settle`). K_cc couples the nodes along a contact surface only and is factored once.
///
/// The rest is of the order of one window: over a window in which a pair closes or opens, the trapezoidal rule and
/// central difference give it the work 1/2 (r_n + r_{n+1}) (g_{n+1} - g_n), which is not zero. `give_back` returns it
/// by an impulse between the inward nodes of the two sides, as a discrete gradient of the contact's potential would
/// (Gonzalez 1996), so that energy is kept over any number of impacts.
class MasslessNodes {
 public:
  /// Moves the masses of all contact nodes in `states`. Throws ConfigError for a node that has no neighbour to take
  /// them.
  MasslessNodes(const ContactSurface& surface, std::vector<BodyState>& states);

  /// A vector per part.
  using OfPart = std::function<Eigen::VectorXd&(std::size_t part)>;
  using ReadOfPart = std::function<const Eigen::VectorXd&(std::size_t part)>;

  /// Sets the massless displacements in `u` as above; `external` [N]. Returns r per pair [N].
  const Eigen::VectorXd& settle(const std::vector<BodyState>& states, const ReadOfPart& external, const OfPart& u);
  /// Calls f(part, dof) for every massless degree of freedom; they have no rates of their own.
  template <class F>
  void for_each_dof(const F& f) const {
    for (std::size_t part = 0; part < statics_.size(); ++part) {
      if (!statics_[part]) continue;
      for (const int dof : statics_[part]->dofs) f(part, dof);
    }
  }

  /// In the window being tried, `made_j` is the energy that the normal force of a pair made. Returns the impulse on the
  /// inward nodes of B along +n (on those of A the opposite) [N s] that takes it back, as far as one within
  /// +-`most_n_s` can, and applies it to `velocity` (by part); the rest is kept for the next window.
  double give_back(std::size_t pair, double made_j, double most_n_s, const std::vector<BodyState>& states,
                   const std::function<double*(std::size_t part)>& velocity);
  /// Work of the impulses of the trial [J].
  [[nodiscard]] double trial_work_j() const { return trial_work_j_; }
  void begin_trial() { trial_work_j_ = 0.0; }
  /// The trial's debts become final.
  void accept() { state_.debt_j = trial_debt_j_; }

  /// All that the next window needs beside the motion.
  struct State {
    RootProblem::Solution last;  ///< of `settle`, to start the next from
    std::vector<double> debt_j;  ///< per pair: energy made and not yet given back

    void archive(Archive& a) { a(last, debt_j); }
  };
  [[nodiscard]] const State& state() const { return state_; }
  void restore(const State& state) { state_ = state; }

 private:
  /// A degree of freedom that took mass: by how much of the pair's relative velocity along n it counts, B minus A.
  struct Share {
    std::size_t part;
    int dof;
    double of_rate;
  };
  /// The massless dofs of a part.
  struct Statics {
    std::vector<int> dofs;
    std::vector<int> place;  ///< per dof of the part: index into `dofs`, or -1
    fem::SparseMatrix rows;  ///< of K, all columns
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>> factor;  ///< of K_cc
    Eigen::VectorXd moved;

    void solve();  ///< moved = K_cc^-1 moved
  };
  void move_masses(std::vector<BodyState>& states);
  void factor(const std::vector<BodyState>& states);
  template <class F>
  void for_each_massless(const Pair& pair, const F& f);
  /// Adds n r of every pair to `moved` of its parts.
  void load(const Eigen::VectorXd& normal_forces);

  const ContactSurface* surface_;
  std::vector<std::unique_ptr<Statics>> statics_;  ///< per part; null without massless dofs
  std::optional<RootProblem> root_;
  State state_;
  Eigen::VectorXd gap_free_;
  std::vector<std::vector<Share>> inward_;  ///< per pair
  std::vector<double> trial_debt_j_;
  double trial_work_j_ = 0.0;
};

}  // namespace ricochet::solver
