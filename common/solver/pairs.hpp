#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"

/// Contact kinematics shared by both solvers: node pairs on flat surfaces, normal n from the first surface (A) to the
/// second (B), tangent t = (-n_y, n_x).
///   gap     g = g0 + n . (u_B - u_A),   open when g > 0            (Eq. 11, 17, 18)
///   slip      = t . (du_B - du_A) over a window
/// A contact force r acts on B along +n and on A along -n; a friction force acts on B along +t and on A along -t.
namespace ricochet::solver {

/// Where one side of a pair lives among the parts of a participant; `part` -1: a rigid plane, which does not move.
struct PairSide {
  int part = -1;
  int node = -1;  ///< local node of the part
};

struct Pair {
  PairSide a, b;
  double gap0_m = 0.0;
  double area_m2 = 0.0;
};

enum class ContactState { open, stick, slip };

/// The scene's contact pairs in the local numbering of a participant's parts (all contact nodes must be among them).
[[nodiscard]] std::vector<Pair> local_pairs(const scene::Problem& problem,
                                            const std::vector<scene::ParticipantPart>& parts);

/// d . (x_B - x_A) of a pair, with x one vector per part (`of_part(part)`), d the normal or the tangent.
template <class OfPart>
double relative(const Pair& pair, const Eigen::Vector2d& direction, int components, const OfPart& of_part) {
  double sum = 0.0;
  for (int c = 0; c < components; ++c) {
    if (pair.b.part >= 0) sum += direction[c] * of_part(pair.b.part)[pair.b.node * components + c];
    if (pair.a.part >= 0) sum -= direction[c] * of_part(pair.a.part)[pair.a.node * components + c];
  }
  return sum;
}

/// Contact forces with a larger residual are counted as not converged, and the user is warned.
constexpr double converged_contact_residual = 1e-6;

/// What the contact owner reports; names of the columns, in the order of `append`. A contact force is the impulse that
/// acted over the window, divided by its size: the only force that all laws and integrators share, and the one for
/// which sum F dt = change of momentum holds exactly.
struct ContactRecord {
  double gap_min_m = 0.0;
  double contact_force_n = 0.0;           ///< on B along +n, over the window
  double contact_pressure_mean_pa = 0.0;  ///< that over the area of all pairs
  double principal_stress_mean_pa = 0.0;
  double friction_force_n = 0.0;  ///< on B along +t, over the window
  int pairs_stick = 0, pairs_slip = 0, pairs_open = 0;
  double energy_contact_j =
      0.0;  ///< work done so far by the normal contact forces: what impacts cost (a loss is negative)
  double energy_friction_j = 0.0;                                ///< dissipated so far by friction
  double contact_impulse_n_s = 0.0, friction_impulse_n_s = 0.0;  ///< sums of F dt so far
  // Of the contact problems since the row before; all zero where they have a closed form.
  int contact_iterations = 0;
  double contact_residual = 0.0;  ///< largest violation of their conditions, relative to the largest normal force
  int contact_unconverged = 0;    ///< windows so far in which that was above `converged_contact_residual`
};
[[nodiscard]] std::vector<std::string> report_columns();
void append(const ContactRecord& report, std::vector<double>& row);

}  // namespace ricochet::solver
