#pragma once

#include <vector>

#include "common/problem/problem.hpp"

namespace ricochet::scene {

/// Critical time step of central difference on some elements of a body with the full nodal masses of the whole body:
///   dt = 2 / omega_max(K_E, M)  [s],
/// the stability limit of a coupling with shared summed masses (Hughes and Liu 1978): it does not depend on the
/// stiffness of the other elements. `own_mass`: with the mass of those elements alone, the limit of an explicit side
/// that a dual protocol couples. Supported degrees of freedom are left out; infinity without elements. It is found to
/// 1e-9, in a large body to 5e-4 from above (fem::max_frequency_squared), but within 2e-3 of `step_s` to 1e-9 there,
/// too: who asks whether a step is below it need not know more, and most steps lie a few percent below.
[[nodiscard]] double critical_time_step(const BodyProblem& body, const std::vector<bool>& of_element, bool own_mass,
                                        double step_s);
/// The same for elements that are assembled already.
[[nodiscard]] double critical_time_step(const BodyProblem& body, const fem::Part& part, bool own_mass, double step_s);

/// Whether a step is at most the critical one of some elements with the masses of the whole body; of bodies of any
/// size found no more exactly than the answer takes.
[[nodiscard]] bool is_stable_step(const BodyProblem& body, const std::vector<bool>& of_element, double step_s);

/// A bound on the critical step of a part, which as a rule comes within a few per cent of it, by a few products with
/// its K, `stiffness` [s]: for who is told the critical step. Infinity without elements.
[[nodiscard]] double largest_critical_time_step(const BodyProblem& body, const fem::Part& part,
                                                const fem::StiffnessProduct& stiffness, bool own_mass);

/// The elements that follow the explicit step; in `all_implicit`, which takes the step of `all_explicit`, all.
[[nodiscard]] std::vector<bool> explicit_elements(const Problem& problem, const BodyProblem& body);

/// The elements whose critical step a participant keeps: with summed masses all of its role in the body, in a dual
/// protocol its own.
[[nodiscard]] std::vector<bool> limiting_elements(const Problem& problem, const BodyProblem& body,
                                                  const ParticipantSpec& participant);

/// A body's part that is assembled already.
struct AssembledPart {
  int body = -1;  ///< index into Problem::bodies
  const fem::Part* part = nullptr;
};
/// Smallest critical step over a participant's parts [s], infinity without any; as exactly as `step_s` asks. One that
/// the problem was built with is not found once more.
[[nodiscard]] double critical_time_step(const Problem& problem, const ParticipantSpec& participant,
                                        const std::vector<AssembledPart>& parts, double step_s);

/// The same by the element bound, 2 / max omega_e over those elements, each with its own lumped mass [s]: never above
/// the exact one, because every node's mass is at least the sum of theirs (Hughes, The Finite Element Method, 9.2).
[[nodiscard]] double element_bound_time_step(const BodyProblem& body, const std::vector<bool>& of_element);

/// The same of one element, by itself [s].
[[nodiscard]] double element_critical_step(const BodyProblem& body, int element);
/// The element bound of each element that does not touch the contact, by itself [s]: where the automatic partition,
/// which makes the others implicit with any step, changes. The order means nothing.
[[nodiscard]] std::vector<double> element_critical_steps(const Problem& problem);

/// Critical time step of central difference on all bodies with every contact pair closed by a penalty spring of
/// alpha * area [N/m]. For two equal bars, or one against a rigid plane, of element size h:
///   dt = (h/c) sqrt(2 / (1 + sqrt(1 + (s alpha_n/k)^2))),  k = E A/h,  s = 2 for two bars, 1 against a plane.
[[nodiscard]] double penalty_critical_time_step(const Problem& problem);

/// Lumped mass of every node of the whole body [kg].
[[nodiscard]] Eigen::VectorXd body_lumped_mass(const BodyProblem& body);

}  // namespace ricochet::scene
