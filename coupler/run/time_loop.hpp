#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "coupler/protocols/protocol.hpp"
#include "coupler/results/summary.hpp"
#include "coupler/run/separation_switch.hpp"

namespace ricochet::coupler {

/// `time.flight_step_s`.
struct FlightSteps {
  double step_s = 0.0, flight_step_s = 0.0, end_s = 0.0;
  WindowClock* clock = nullptr;  ///< of the run, which learns the sizes here
};

struct LoopSettings {
  std::int64_t last_window = 0;
  int resynchronise_every = 0;    ///< windows; 0: never
  bool coupled = true;            ///< false: baseline, many windows at a request
  bool may_switch = false;        ///< the implicit participant may integrate explicitly after separation
  bool frequent_records = false;  ///< a baseline, too, is asked for few windows at a time
  int stop_every = 0;             ///< windows: a baseline, too, comes to the end of one that divides by it; 0: any
  std::optional<FlightSteps> flight{};  ///< then windows have two sizes
};

/// Drives a protocol from the first window to the last, or until the owner of the contact says that it is over.
class TimeLoop {
 public:
  /// `on_records(window)` is called whenever the links have brought history rows; `on_window(window)` after each step,
  /// when everyone is at the end of the same accepted window.
  TimeLoop(Coupling& coupling, Protocol& protocol, const LoopSettings& settings,
           std::function<void(std::int64_t)> on_records, std::function<void(std::int64_t)> on_window = {});

  void run();
  /// Reads or writes what it goes on from between windows.
  void archive(Archive& a);
  [[nodiscard]] std::int64_t window() const { return window_; }  ///< last accepted
  [[nodiscard]] const std::vector<SwitchEvent>& switches() const { return switches_; }

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] Step next_step();
  void adapt_chunk(double elapsed_s);
  bool goes_on();
  void change_window_size();
  void choose_window_size(const FlightSteps& steps);
  void switch_integration();

  Coupling& coupling_;
  Protocol& protocol_;
  LoopSettings settings_;
  std::function<void(std::int64_t)> on_records_, on_window_;
  SeparationSwitch separation_, flight_;
  std::vector<SwitchEvent> switches_;
  std::int64_t window_ = 0, chunk_ = 1, records_window_ = 0;
  Clock::time_point records_time_ = Clock::now();
};

}  // namespace ricochet::coupler
