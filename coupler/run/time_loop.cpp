#include "coupler/run/time_loop.hpp"

#include <algorithm>

namespace ricochet::coupler {
namespace {

/// History rows come at least this often: early enough for the energy watch to see an instability long before a number
/// overflows, seldom enough to cost nothing.
constexpr std::int64_t windows_between_records = 32;
constexpr std::chrono::milliseconds time_between_records{100};
/// A baseline is asked for as many windows as take about this long, so that it is neither slowed down nor out of hand.
constexpr double chunk_s = 0.05;
constexpr std::int64_t largest_chunk = 4096;

}  // namespace

TimeLoop::TimeLoop(Coupling& coupling, Protocol& protocol, const LoopSettings& settings,
                   std::function<void(std::int64_t)> on_records, std::function<void(std::int64_t)> on_window)
    : coupling_(coupling),
      protocol_(protocol),
      settings_(settings),
      on_records_(std::move(on_records)),
      on_window_(std::move(on_window)) {}

void TimeLoop::archive(Archive& a) {
  a(window_, separation_, switches_);
  if (settings_.flight) a(flight_);
  records_window_ = window_;
}

void TimeLoop::run() {
  on_records_(window_);
  while (goes_on()) {
    change_window_size();
    const Step step = next_step();
    const auto begin = Clock::now();
    protocol_.step(coupling_, step);
    window_ = coupling_.window();
    coupling_.note_interface_drift();
    if (settings_.coupled) {
      if (settings_.may_switch) switch_integration();
    } else {
      adapt_chunk(std::chrono::duration<double>(Clock::now() - begin).count());
    }
    if (step.records) on_records_(window_);
    if (on_window_) on_window_(window_);
  }
}

/// Before the first window nobody knows how fast bodies close.
bool TimeLoop::goes_on() {
  if (settings_.flight && window_ > 0) choose_window_size(*settings_.flight);
  return window_ < settings_.last_window && !coupling_.contact().finished_early;
}

Step TimeLoop::next_step() {
  Step step;
  step.accepted_window = window_;
  step.touching = coupling_.contact().pairs_closed > 0;
  const bool one_by_one = settings_.coupled || settings_.flight;
  step.windows = one_by_one ? 1 : std::min(chunk_, settings_.last_window - window_);
  if (settings_.frequent_records) step.windows = std::min(step.windows, windows_between_records);
  if (settings_.stop_every > 0)
    step.windows = std::min<std::int64_t>(step.windows, settings_.stop_every - window_ % settings_.stop_every);
  if (const auto change = coupling_.clock().next_change(window_); change > 0)
    step.windows = std::min(step.windows, change - window_);
  const std::int64_t end = window_ + step.windows;
  step.absolute = settings_.coupled && settings_.resynchronise_every > 0 && end % settings_.resynchronise_every == 0;
  const auto now = Clock::now();
  step.records = !one_by_one || end == settings_.last_window || end - records_window_ >= windows_between_records ||
                 now - records_time_ >= time_between_records;
  if (step.records) {
    records_window_ = end;
    records_time_ = now;
  }
  return step;
}

void TimeLoop::adapt_chunk(double elapsed_s) {
  if (elapsed_s < 0.5 * chunk_s) chunk_ = std::min(2 * chunk_, largest_chunk);
  if (elapsed_s > 2.0 * chunk_s) chunk_ = std::max<std::int64_t>(chunk_ / 2, 1);
}

/// From what all know of the window before, not from how long it took: a run that goes on has the same sizes.
void TimeLoop::choose_window_size(const FlightSteps& steps) {
  const bool flies = flight_.apart(coupling_.contact(), steps.flight_step_s);
  coupling_.change_window_size(flies ? steps.flight_step_s : steps.step_s);
  *steps.clock = coupling_.clock();
  settings_.last_window = static_cast<std::int64_t>(coupling_.clock().window_at(steps.end_s));
}

void TimeLoop::change_window_size() {
  const auto& clock = coupling_.clock();
  if (window_ > 0 && clock.size_s(window_ + 1) != clock.size_s(window_)) protocol_.reconfigure(coupling_);
}

void TimeLoop::switch_integration() {
  const bool to_explicit = separation_.update(coupling_.contact(), coupling_.window_size_s());
  if (to_explicit == coupling_.all_explicit()) return;
  coupling_.synchronise(to_explicit ? Integration::explicit_central : Integration::implicit_newmark);
  switches_.push_back({coupling_.clock().time_s(window_), to_explicit ? Role::explicit_solver : Role::implicit_solver});
}

}  // namespace ricochet::coupler
