#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/base/parallel.hpp"
#include "common/fem/part.hpp"
#include "common/fem/stiffness_product.hpp"

namespace ricochet::fem {

/// Local time steps as another stiffness (stabilised leapfrog: Diaz, Grote 2009; Grote, Michel, Sauter 2021). Central
/// difference takes windows dt that are too long for some rows of K. Let P_1 contain P_2 contain ... P_L be rows, each
/// with those that are too stiff for the steps of the level before and one layer of nodes. A force f held over a window
/// amounts at its end to S f = S_1 f, by two steps of each level in one of the level before:
///   S_l f = S_{l+1} (f - kappa_l K P_l M^-1 S_{l+1} f),   S_{L+1} f = f,
///   tau_0 = dt,   tau_l^2 = tau_{l-1}^2 T_2(d)/(4 d^2),   kappa_l = tau_l^2/4,   d = 1 + nu/4,   T_2(d) = 2 d^2 - 1.
/// M a = S (f - K u): K~ = S K is symmetric, and central difference with it is stable as long as the rows that are in
/// no level, alone, bear the window and those in level l the step tau_l. S keeps the sum of forces, since K does not
/// push a translation. A window takes one product with the rows of level l for 2^(l-1) times.
class LocalSteps {
 public:
  /// No local steps.
  LocalSteps() = default;
  /// Levels for windows of `window_s`; `inverse_mass` per degree of freedom, 0 where held [1/kg]. A row's stiffness is
  /// measured by sum_j |K_ij|/m_i, scaled by what omega_max^2 of all of K is of the largest of them; where K~ does not
  /// bear the window with these levels the scale goes up, to 1 at most, which is Gershgorin's bound. Throws SolverError
  /// where that does not help. `expected`: the first levels, untried, for who asks what they would cost.
  enum class Levels { borne, expected };
  struct Nodes {
    std::vector<bool> may_be_stiff;  ///< the others bear the window, whatever the bound says of them; empty: all may be
    std::vector<bool> whole;         ///< takes no small step: somebody else moves it, or a dashpot; empty: none
  };
  LocalSteps(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, int components, double window_s,
             Levels levels = Levels::borne, Nodes nodes = {{}, {}});

  /// From here on of a share of the part, which has all nodes that S reaches. `place`: per node of the part its number
  /// there, or -1; `nodes`: how many the share has.
  void renumber(const std::vector<int>& place, int nodes);

  /// From here on computes with these threads, to the same bits.
  void compute_with(const std::shared_ptr<Parallel>& parallel);

  [[nodiscard]] bool any() const { return !levels_.empty(); }
  /// force = S force [N].
  void spread(Eigen::VectorXd& force);
  /// Nodes whose rows S changes, ascending: those that step locally and their neighbours.
  [[nodiscard]] const std::vector<int>& reached() const { return reached_; }
  /// A node takes local steps: a force on it is spread.
  [[nodiscard]] bool steps_locally(int node) const { return level_of_node_[static_cast<std::size_t>(node)] > 0; }
  /// Nodes by the steps that they take in a window: 1, 2, 4, ... .
  [[nodiscard]] std::vector<int> nodes_by_level() const;
  /// The longest window that the coarsest node bears as one step; without levels the window itself [s].
  [[nodiscard]] double longest_window_s() const { return longest_window_s_; }
  /// Rows of K that a window multiplies beside the whole, over all rows.
  [[nodiscard]] double extra_rows() const;

 private:
  struct Level {
    std::vector<int> of_before;    ///< its dofs, with one layer more, as the level before numbers them
    StiffnessProduct stiffness;    ///< of these
    Eigen::VectorXd kappa;         ///< kappa_l P_l M^-1
    Eigen::VectorXd force, moved;  ///< S_{l+1} f, and what of it moves the level's rows
    Eigen::VectorXd pull;
  };
  void set_levels(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, double window_s,
                  const Eigen::VectorXd& stiffness_of_node);
  void add_level(const SparseMatrix& stiffness, const Eigen::VectorXd& inverse_mass, double kappa, int level,
                 std::vector<int>& numbered);
  void step(std::size_t level, Eigen::VectorXd& force);
  [[nodiscard]] bool takes_none(std::size_t node) const { return !nodes_.whole.empty() && nodes_.whole[node]; }
  [[nodiscard]] bool bears(const StiffnessProduct& stiffness, const Eigen::VectorXd& mass,
                           const std::vector<bool>& fixed, double window_s);

  int components_ = 1;
  Nodes nodes_;
  double longest_window_s_ = 0.0;
  std::vector<int> level_of_node_;  ///< deepest P_l that it is in
  std::vector<int> reached_;
  std::vector<Level> levels_;
};

}  // namespace ricochet::fem
