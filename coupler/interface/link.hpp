#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "coupler/interface/interface_map.hpp"
#include "coupler/interface/peer.hpp"
#include "coupler/interface/window_rows.hpp"

namespace ricochet::coupler {

/// The span that one step of a protocol covers.
struct Step {
  std::int64_t accepted_window = 0;  ///< the last one; the step computes from the next on
  std::int64_t windows = 1;          ///< how many; more than one only without a coupling (baselines)
  bool absolute = false;             ///< exchange absolute values besides the increments
  bool records = false;              ///< bring the history rows collected so far
  std::int64_t substep = 0;          ///< the one step within the window that is meant; 0: the whole window
  bool ends_window = true;           ///< false: more substeps of this window follow
  bool touching = false;             ///< contact pairs were closed at the end of the last window
};

enum class Acceptance { trial, at_once };

/// One participant as a protocol sees it: absolute interface values in the shared numbering. On the wire travel
/// increments since the participant's last accepted window (Eq. 6); this class keeps, for either direction, the
/// absolute values that the receiving end has accumulated, so that an increment never carries the rounding of the one
/// before:
///   sent:      d = x - x_received,   x_received += d      (both ends do the same sum)
///   received:  y = y_accepted + d
/// A resynchronisation replaces both by the absolute values and keeps the largest relative difference.
class Link {
 public:
  Link(Peer peer, const PeerDescription& description, const InterfaceRows& rows);

  [[nodiscard]] const std::string& name() const { return peer_.name; }
  [[nodiscard]] bool implicit() const { return description_.role == Role::implicit_solver; }
  /// Its link input is a force, and it answers its motion.
  [[nodiscard]] bool driven_by_force() const { return driven_by_force_; }
  [[nodiscard]] const PeerDescription& description() const { return description_; }
  [[nodiscard]] const InterfaceRows& rows() const { return rows_; }

  /// `request`: without its masses. `own_masses` per own interface node [kg].
  void post_initialize(wire::Initialize request, const std::vector<double>& own_masses);
  void wait_initialized();
  /// `input` (here and below) in own rows.
  void post_synchronise(Integration integration, const std::vector<double>& input);
  void wait_synchronised();
  /// Between windows. `stiffness`: of the link, own rows; 0 rows: none.
  void post_reconfigure(double window_size_s, const Eigen::MatrixXd& stiffness);
  void wait_reconfigured();
  /// A synchronisation must follow.
  void post_load_state(const std::vector<double>& state, FrozenContact frozen_contact);
  void wait_state_loaded();
  /// The answer is valid until the next message.
  void post_read_state();
  const wire::State& wait_state();
  /// All that the participant goes on from after its last accepted window; valid until the next message.
  void post_save_state();
  const std::string& wait_saved_state();
  /// In a run that has just been started: the participant goes on from there, and so does this end with `archive`.
  void post_restore_state(const std::string& saved);
  void wait_state_restored();
  /// Reads or writes the state that this end goes on from, between windows.
  void archive(Archive& a);
  /// `input` at the end of the step: displacement [m] or force [N], by which the participant is driven.
  void post_advance(const Step& step, const std::vector<double>& input, Acceptance acceptance);
  void wait_advanced();
  /// Makes the last trial final.
  void post_accept(const Step& step);
  void wait_accepted();
  void post_finish();
  const wire::Finished& wait_finished();

  /// Link input that the participant has accepted last, own rows.
  [[nodiscard]] const std::vector<double>& input() const { return received_input_; }
  /// The last answer, own rows: displacement [m] of who is driven by force, else force [N].
  [[nodiscard]] const std::vector<double>& output() const { return output_; }
  /// Lumped mass of its own elements, per row of the interface and component [kg].
  [[nodiscard]] std::vector<double> own_mass_kg() const;
  [[nodiscard]] const std::vector<double>& velocity_m_s() const { return velocity_; }
  [[nodiscard]] const std::vector<double>& acceleration_m_s2() const { return acceleration_; }
  [[nodiscard]] const wire::ContactReport& contact() const { return contact_; }
  /// Largest difference between accumulated and absolute values so far, relative to the largest absolute value.
  [[nodiscard]] double largest_drift() const { return largest_drift_; }
  [[nodiscard]] std::int64_t window() const { return window_; }  ///< last accepted
  [[nodiscard]] double setup_s() const { return setup_s_; }
  /// All that has left the model as the participant last said, rows of wire::departure_columns numbers.
  [[nodiscard]] const wire::Array& departures() const { return departures_; }
  /// Where nodes of outlines were when history rows last came; see the field `outline`.
  [[nodiscard]] const wire::Array& outline() const { return outline_; }
  /// History rows received since the last call (row-major, as many columns as the description names).
  [[nodiscard]] std::vector<double> take_records() { return records_.taken(); }
  /// The same of the rows of probes and gauges.
  [[nodiscard]] std::vector<double> take_probes() { return probes_.taken(); }
  /// The same of contact forces, rows of 1 + contacts numbers; who does not tell them has none.
  [[nodiscard]] std::vector<double> take_contact_forces() { return contact_forces_.taken(); }
  /// The same of the rows of axial stress.
  [[nodiscard]] std::vector<double> take_axial_stress() { return axial_stress_.taken(); }

 private:
  template <class Body>
  Body& wait();
  void take_acceptance(const wire::AcceptedWindow& answer);
  void take_absolute(const wire::Array& absolute);
  void take_rates(wire::Rates& answer);
  void take_records_of(const wire::Records& answer, bool asked_for);
  void require_no_contact_of_others(const wire::ContactReport& report) const;
  void require_asked_for(const wire::Array& array, bool asked_for, const char* field) const;
  void take_departures(const wire::Array& departures);
  void take_outline(const wire::Array& outline);
  void require_columns(const wire::Array& array, int columns, const char* field) const;
  void require_body(double body, const char* field) const;
  [[nodiscard]] std::int64_t answered_window(bool finished_early) const;
  void require_rows(const wire::Array& array, const char* field) const;

  Peer peer_;
  PeerDescription description_;
  wire::Message request_;
  std::int64_t answer_window_ = 0, last_requested_ = 0;  ///< of the last answer; that was asked for
  InterfaceRows rows_;
  std::vector<double> received_input_, trial_input_, output_accepted_, output_, velocity_, acceleration_;
  bool output_is_accepted_ = true;  ///< and what `output_accepted_` holds is older
  Acceptance acceptance_ = Acceptance::at_once;
  bool driven_by_force_ = false, ends_window_ = true, records_requested_ = false, absolute_requested_ = false;
  wire::ContactReport contact_;
  wire::Array departures_, outline_;
  double largest_drift_ = 0.0;
  double setup_s_ = 0.0;
  std::int64_t window_ = 0;
  WindowRows records_, axial_stress_, probes_, contact_forces_;
};

}  // namespace ricochet::coupler
