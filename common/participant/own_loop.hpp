#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "common/participant/participant.hpp"

namespace ricochet::participant {

/// The second face of the SDK, for codes that own their time loop:
///
///   OwnLoop loop(description, options);
///   loop.initialize(output at t = 0);
///   while (loop.ongoing()) {
///     if (loop.must_save()) saved = state;
///     state.step(loop.max_time_step(), loop.read());
///     loop.write(link output, history row);
///     loop.advance();
///     if (loop.must_restore()) state = saved;
///   }
///   return loop.finalize();
///
/// Every turn computes one whole window, which ends when the time `max_time_step()` has passed. It may be 0: then the
/// coupler synchronises, which is a window in which no time passes (new accelerations from the link values that are
/// read, nothing else moves). Roles, shapes and signs are those of `Participant`; `write` brings what its `advance`
/// and `record` bring. The conversation runs in a thread of its own that only works while this one waits.
class OwnLoop {
 public:
  /// Throws ConfigError if the endpoint is none, ParticipantError if the description contradicts itself.
  OwnLoop(Description description, const ServeOptions& options);
  OwnLoop(const OwnLoop&) = delete;
  OwnLoop& operator=(const OwnLoop&) = delete;
  /// A loop that is left before its end, by an exception for example, ends the run: the coupler is told.
  ~OwnLoop();

  /// Meets the coupler, and returns when it has set `setup()`; `output` and `record`: link output and history row at t
  /// = 0. Throws Error if the run failed.
  void initialize(LinkOutput output, std::vector<double> record = {});
  /// The coupler's settings; after `initialize`.
  [[nodiscard]] const Setup& setup() const;
  /// Tells what a long set-up is doing, and the share of it that is done (< 0: nobody knows): between `initialize` and
  /// the first question about the time loop, while the coupler still waits for an answer to its `initialize`. Throws
  /// ConfigError at any other time.
  void progress(std::string_view doing, double share_done = -1.0);
  /// By which integration an implicit participant is to go on from here.
  [[nodiscard]] Integration integration() const;

  /// There is a window to compute.
  [[nodiscard]] bool ongoing() const;
  /// Size of the window to compute [s]; 0: synchronisation.
  [[nodiscard]] double max_time_step() const;
  /// A new window begins, and the coupler may ask for it again.
  [[nodiscard]] bool must_save() const;
  /// The coupler asks for the same window again, or drops it: go back to where `must_save` was true.
  [[nodiscard]] bool must_restore() const;
  /// Link input at the end of the window (explicit: displacement [m], implicit: force [N]).
  [[nodiscard]] const std::vector<double>& read() const;
  /// Link output and history row (as many numbers as `record_columns`) at the end of the window.
  void write(const LinkOutput& output, const std::vector<double>& record = {});
  /// The window is computed: exchanges, and waits for what is next. Throws Error if the run failed.
  void advance();
  /// Waits for the end of the conversation; the exit code for `main`.
  int finalize();

 private:
  class Relay;
  /// The relay, with a window to compute. Throws Error if the run failed.
  [[nodiscard]] Relay& ready() const;

  std::unique_ptr<Relay> relay_;
};

}  // namespace ricochet::participant
