#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// All that can be said, and refused, before a process starts.
struct ParticipantPlan {
  std::string name;
  Role role = Role::explicit_solver;
  int nodes = 0, elements = 0, interface_nodes = 0;
  int unknowns = 0;                 ///< free degrees of freedom that it integrates
  double critical_time_step_s = 0;  ///< infinity for an implicit participant, and where small steps make up for it
};
/// The small steps that explicit elements of a body take.
struct LocalStepsPlan {
  std::string body;
  std::vector<int> nodes;         ///< by the steps that they take in a window: 1, 2, 4, ...
  double extra_rows = 0.0;        ///< that a window multiplies beside the whole stiffness, over all rows
  double longest_window_s = 0.0;  ///< that the coarsest node bears as one step
  std::string jump{};             ///< a warning of held nodes whose velocity jumps among small steps, or none
};
struct BodyPlan {
  std::string name;
  Eigen::Vector3d extent_m{0.0, 0.0, 0.0};
  double mass_kg = 0.0, volume_m3 = 0.0;   ///< axisymmetric: of the whole ring; plane strain: of its thickness
  double speed_m_s = 0.0, energy_j = 0.0;  ///< of the initial velocity
  bool rigid = false;
};
struct Plan {
  std::vector<BodyPlan> bodies;
  std::vector<ParticipantPlan> participants;
  std::vector<LocalStepsPlan> local_steps;         ///< per body that takes some
  double added_mass_kg = 0, added_mass_share = 0;  ///< by mass scaling, and over what all bodies have by their density
  long long windows = 0;
  int contact_pairs = 0;
  double penalty_step_ratio = 0;  ///< sqrt(2 alpha_n / m) dt, largest over the pairs; 0 without penalty
  /// alpha_n / k, k = rho c_L^2 A / h (bar: E A / h) of the stiffer contact element
  double penalty_stiffness_ratio = 0;
  double penalty_delay_s = 0;     ///< bars: by how much the penalty model releases late, 1.678347 tau; else 0
  double penalty_critical_s = 0;  ///< all_explicit with penalty: critical step while in contact; else 0
  std::string switch_obstacle;    ///< see check_switch.hpp
  std::vector<std::string> warnings;
  std::vector<std::string> notes;  ///< what could be left out; see check_reach.hpp
};

/// Counts what each participant has to do, and the local steps of its bodies; refuses nothing else.
[[nodiscard]] std::vector<ParticipantPlan> plan_participants(const Problem& problem,
                                                             std::vector<LocalStepsPlan>* local_steps = nullptr);
/// The critical step of an explicit participant by the element bound [s], see critical_step.hpp; infinity for an
/// implicit one.
[[nodiscard]] double element_bound_time_step(const Problem& problem, const ParticipantSpec& participant);
/// 2/omega_max(K_E, M) of everything that is integrated explicitly, the limit that `plan` refuses to exceed and
/// `ricochet stability` predicts; infinity if nothing is [s].
[[nodiscard]] double critical_time_step(const std::vector<ParticipantPlan>& participants);

/// Throws ConfigError where the scene cannot work: a step above the critical step of what is explicit (with shared
/// masses), trapezoidal or central-difference penalty beyond its bound, and everything build_problem refuses.
[[nodiscard]] Plan plan(const Problem& problem);
/// The plan as the text that `ricochet check` prints.
[[nodiscard]] std::string to_text(const Problem& problem, const Plan& plan);

}  // namespace ricochet::scene
