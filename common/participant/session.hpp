#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/participant/incremental_link.hpp"
#include "common/participant/participant.hpp"
#include "common/wire/lifecycle.hpp"
#include "common/wire/message.hpp"

namespace ricochet::participant {

/// A participant's end of the conversation without the bytes: turns requests of the coupler into calls of
/// `Participant`, and the results into replies. `serve` drives it over a socket; a coupler in the same process can call
/// it directly.
class Session {
 public:
  /// Asks `participant`, which must outlive the session, for its description. Throws ParticipantError if that
  /// contradicts itself, and what `describe` throws.
  explicit Session(Participant& participant);

  /// The first message to send.
  void hello(wire::Message& message);
  /// Does what `request` asks and fills in `reply`; true if that is to be sent (`welcome` has no answer). Throws what
  /// the participant throws; ProtocolError if the request is illegal now or its numbers make no sense; ParticipantError
  /// if the participant's results have the wrong size, SolverError if they are not finite; for a `failure` of the
  /// coupler an Error of its code. After an error only `failure` makes sense.
  bool handle(const wire::Message& request, wire::Message& reply);
  /// To be called when a reply has been sent: finishes what the reply did not have to wait for (accepting a window that
  /// has no contact to report, history rows, fields) and lets the participant work ahead. Throws what those throw.
  void work_ahead();
  /// Where what the participant says of its progress in `initialize` goes; called before the conversation begins.
  void on_progress(TellProgress tell) { setup_.progress = std::move(tell); }
  /// Fills in the message that tells the coupler of progress.
  void progress(std::string_view doing, double share_done, wire::Message& message);
  /// Fills in the message that tells the coupler why this end stops; ends the conversation.
  void failure(ExitCode code, const std::string& text, wire::Message& message);

  [[nodiscard]] const std::string& name() const { return description_.name; }
  /// Finished or failed: nothing more is to be sent or received.
  [[nodiscard]] bool over() const { return lifecycle_.done(); }
  /// Longest wait for the coupler [s]; < 0: it has not said yet.
  [[nodiscard]] double timeout_s() const { return timeout_s_; }
  /// Everybody is initialized; before that one of the others may need long for it.
  [[nodiscard]] bool started() const { return synchronised_; }
  /// The window that was computed last, or is being computed.
  [[nodiscard]] std::int64_t window() const { return window_; }
  /// Notes time spent waiting for the coupler [s], for the `finished` message.
  void add_wait(double time_s) { wait_s_ += time_s; }

  static constexpr std::size_t max_spans = 2000;

 private:
  using Instant = std::chrono::steady_clock::time_point;

  void send(wire::Message& message);
  void check_run(const wire::Header& request) const;
  /// Calls the participant and fills in the reply except its header.
  void answer(const wire::Message& request, wire::Message& reply);
  void note_time(Instant begin);

  void welcome(const wire::Welcome& request, const std::string& run_id);
  void describe(wire::Description& reply) const;
  void initialize(const wire::Initialize& request, wire::Initialized& reply);
  void synchronise(const wire::Synchronise& request, wire::Synchronised& reply);
  void reconfigure(const wire::Reconfigure& request);
  void advance(const wire::Header& header, const wire::Advance& request, wire::Advanced& reply);
  void accept(const wire::Header& header, const wire::Accept& request, wire::Accepted& reply);
  void load_state(const wire::LoadState& request);
  void read_state(wire::State& reply);
  void save_state(wire::SavedState& reply);
  void restore_state(const wire::RestoreState& request);
  void archive(Archive& a);
  void finish(wire::Finished& reply);

  void take_interface_stiffness(const wire::Array& stiffness);
  void take_places(const wire::Initialize& request);
  [[nodiscard]] bool can(Capability capability) const;
  void check_advance(const wire::Header& header, const wire::Advance& request) const;
  void check_substep(const wire::Header& header, std::int64_t windows) const;
  void accept_trial();
  void accept();
  void finish_window();
  using Tell = void (Participant::*)(std::vector<double>&);
  void record();
  void record_axial_stress();
  void record_probes();
  void record_contact_forces();
  void append_row(Tell tell, std::size_t columns, std::vector<double>& rows);
  [[nodiscard]] bool wants_axial_stress(std::int64_t window) const;
  [[nodiscard]] bool wants_probes(std::int64_t window) const;
  void write_fields();
  void put_absolute(wire::Array& absolute) const;
  void put_rates(wire::Rates& reply) const;
  void put_accepted_window(bool records_requested, wire::AcceptedWindow& reply);
  void put_departures(wire::Array& array);
  void put_outline(wire::Array& array);
  void put_records(bool requested, wire::Records& reply);
  void put_times(wire::Finished& reply) const;
  void require_rows(const wire::Array& array, std::string_view field, int columns) const;
  void require_output(bool rates_needed) const;

  Participant& participant_;
  Description description_;
  Setup setup_;
  wire::Lifecycle lifecycle_;
  IncrementalLink link_;
  LinkOutput output_;
  ContactStatus contact_;
  std::string run_id_;
  std::int64_t sequence_ = 0, window_ = 0, accepted_window_ = 0, fields_window_ = -1;
  std::int64_t substep_ = 0, accepted_substep_ = 0;  ///< of the trial (0: whole window); of the window under way
  double timeout_s_ = -1.0;
  bool can_repeat_ = false, tried_ = false;  ///< tried: a trial window is not accepted yet
  bool touching_ = false;                    ///< contact was closed before the window that is computed
  bool synchronised_ = false, accept_due_ = false, record_due_ = false, stress_due_ = false, probes_due_ = false,
       fields_due_ = false;  ///< put off
  bool moves_ = false;       ///< driven by force: answers displacement, velocity, acceleration
  int nodes_ = 0;
  /// Rows of history, axial stress, probes, contact forces; not sent yet.
  std::vector<double> rows_, stress_rows_, probe_rows_, force_rows_;
  std::int64_t force_columns_ = -1;  ///< contacts whose forces it tells; < 0: not known yet
  std::vector<double> spans_;        ///< window, begin, end of each computing span
  double compute_s_ = 0.0, wait_s_ = 0.0;
};

/// Why a participant stops.
struct Reason {
  ExitCode code;
  std::string text;
};
/// Call in a catch block: the reason, with the window that was being computed. An exception of a solver without a code
/// of its own is a computation that went wrong, unless it is the machine that refuses memory, files or the like.
[[nodiscard]] Reason reason_in(const Session& session);

}  // namespace ricochet::participant
