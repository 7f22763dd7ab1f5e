#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/separation.hpp"
#include "common/body/body_state.hpp"
#include "common/contact/contact_record.hpp"
#include "common/contact/contact_rows.hpp"
#include "common/contact/surface_stress.hpp"
#include "common/fem/vtk_output.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::solver {

/// Force of one pair: normal >= 0 on B along +n, tangential on B along +t and, of solids, along the binormal n x t [N].
struct PairForce {
  double normal = 0.0;
  Eigen::Vector2d tangential{0.0, 0.0};
  ContactState state = ContactState::open;

  void archive(Archive& a) { a(normal, tangential, state); }
};

/// The numbers that a contact's owner counts from window to window.
struct ContactAccount {
  double work_normal_j = 0.0, dissipated_friction_j = 0.0;
  ContactImpulses impulses;  ///< so far
  int iterations = 0;        ///< of the contact problem, or sweeps over pairs that share nodes, since the last report
  double largest_residual = 0.0;  ///< since the last report
  int unconverged = 0;            ///< so far

  void archive(Archive& a) {
    a(work_normal_j, dissipated_friction_j, impulses, iterations, largest_residual, unconverged);
  }
};

/// The contact of a scene in the local numbering of its owner: what can be said of it from the motion alone.
struct ContactSurface {
  ContactSurface(const scene::Problem& problem, const std::vector<BodyState>& states);

  int components;
  /// In which pairs have a force: along the normal and, with friction of any contact, along tangent and binormal; pairs
  /// without friction have forces of zero there.
  Eigen::Index directions;
  bool round;                             ///< a contact has a radius: axisymmetric or solid
  std::vector<std::string> contact_keys;  ///< in the scene file, per contact
  std::vector<Pair> pairs;
  /// A node of surfaces that slide which lies opposite nothing yet.
  struct IdleNode {
    int part, node;
  };
  std::vector<IdleNode> idle;
  SurfaceStress stress;

  /// Forces, pressures, gaps and states at the nodes of each part, for the files of fields.
  [[nodiscard]] std::vector<fem::ContactFields> nodal_fields(const std::vector<BodyState>& states,
                                                             const std::vector<PairForce>& forces) const;
  [[nodiscard]] double gap_min(const std::vector<BodyState>& states) const;       ///< [m]
  [[nodiscard]] double gap_rate_min(const std::vector<BodyState>& states) const;  ///< [m/s]
  /// A record for `report`, and impulses before the first window.
  [[nodiscard]] ContactRecord empty_record() const;
  [[nodiscard]] ContactImpulses no_impulses() const;
  /// Forces, states and impulses summed up, of all contacts and of each of several; gaps and principal stress.
  /// Energies are the account's, and what the forces took to find, which is counted anew from here.
  void report(const std::vector<BodyState>& states, const std::vector<PairForce>& forces, ContactAccount& account,
              ContactRecord& record) const;
  /// Appends the sum of each contact's forces along its normal [N].
  void append_forces(const std::vector<PairForce>& forces, std::vector<double>& row) const;

  /// Throws ConfigError unless so many numbers, of a state that was read, are one a pair, or as many as a pair has.
  void require_one_a_pair(std::size_t count, std::size_t of_a_pair = 1) const;

 private:
  void measure_pressure(const std::vector<BodyState>& states, const std::vector<PairForce>& forces,
                        std::optional<std::size_t> contact, ContactTotals& totals) const;
  /// The totals of one contact, or of all.
  [[nodiscard]] ContactTotals totals(const std::vector<BodyState>& states, const std::vector<PairForce>& forces,
                                     const ContactImpulses& impulses, std::optional<std::size_t> contact) const;
};

/// A contact, the forces of its pairs in the last window, and the parts that its rows number; null where somebody else
/// enforces it.
struct PressedSurface {
  const ContactSurface* surface = nullptr;
  const std::vector<PairForce>* forces = nullptr;
  const std::vector<BodyState>* parts = nullptr;
};

/// Contact status after a window: gaps, separation, and whether `until_separated_plus_s` of the setup has passed.
[[nodiscard]] participant::ContactStatus contact_status(const ContactSurface& surface,
                                                        const std::vector<BodyState>& states, int pairs_closed,
                                                        std::int64_t window, const participant::Setup& setup,
                                                        SeparationWatch& separation);

/// Numbers that the nodes of one process' part have in the whole part, whose nodes include them.
[[nodiscard]] std::vector<int> nodes_in_whole(const fem::Part& own, const fem::Part& whole);

/// Fields of the parts of some processes as those of the whole parts, whose nodes include theirs.
[[nodiscard]] std::vector<fem::ContactFields> of_whole_parts(const std::vector<fem::ContactFields>& fields,
                                                             const std::vector<BodyState>& parts,
                                                             const std::vector<BodyState>& whole);

}  // namespace ricochet::solver
