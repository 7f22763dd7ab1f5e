#include "coupler/interface/link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

/// Kinds of `departures`, from 1 on.
constexpr double departure_kinds = 6;

void set(wire::Array& array, const std::vector<double>& values, int columns) {
  array.rows = static_cast<int>(values.size()) / columns;
  array.columns = columns;
  array.data.assign(values.begin(), values.end());
}

/// Zero rows, as many columns as the interface has: "not given".
void clear(wire::Array& array, int columns) {
  array.rows = 0;
  array.columns = columns;
  array.data.clear();
}

}  // namespace

Link::Link(Peer peer, const wire::Message& description, const InterfaceRows& rows)
    : peer_(std::move(peer)),
      description_(description),
      rows_(rows),
      implicit_(wire::has_role(description, Role::implicit_solver)),
      records_("records", "history row", description.record_columns.size()),
      axial_stress_("axial_stress", "axial stress row", description.axial_stress_columns.size()) {
  const std::size_t size = rows_.shared.size() * static_cast<std::size_t>(rows_.components);
  for (auto* values : {&received_input_, &trial_input_, &output_accepted_, &output_}) values->assign(size, 0.0);
}

std::vector<double> Link::own_mass_kg() const {
  std::vector<double> masses;
  for (const double mass : description_.interface_mass_kg.data) {
    masses.insert(masses.end(), static_cast<std::size_t>(rows_.components), mass);
  }
  return masses;
}

void Link::post_initialize(wire::Message request, const std::vector<double>& own_masses) {
  request.kind = wire::Kind::initialize;
  records_.expect_every(request.history_every);
  axial_stress_.expect_every(request.axial_stress_every);
  if (request.driven_by.empty()) request.driven_by = name_of(implicit() ? Drive::force : Drive::displacement);
  driven_by_force_ = request.driven_by == name_of(Drive::force);
  set(request.interface_mass_kg, own_masses, 1);
  peer_.post(request);
}

void Link::wait_initialized() {
  const auto& answer = wait(wire::Kind::initialized);
  setup_s_ = answer.setup_s;
  take_absolute(answer);
}

void Link::post_synchronise(Integration integration, const std::vector<double>& input) {
  received_input_ = input;
  request_.kind = wire::Kind::synchronise;
  request_.integration = name_of(integration);
  set(request_.link_absolute, received_input_, rows_.components);
  peer_.post(request_);
}

void Link::wait_synchronised() {
  const auto& answer = wait(wire::Kind::synchronised);
  take_absolute(answer);
  take_rates(answer);
}

void Link::post_load_state(const std::vector<double>& state, FrozenContact frozen_contact) {
  request_.kind = wire::Kind::load_state;
  request_.frozen_contact = name_of(frozen_contact);
  set(request_.state, state, 1);
  peer_.post(request_);
}

void Link::wait_state_loaded() { wait(wire::Kind::state_loaded); }

void Link::post_read_state() {
  request_.kind = wire::Kind::read_state;
  peer_.post(request_);
}

const wire::Message& Link::wait_state() {
  const auto& answer = wait(wire::Kind::state);
  if (answer.state.data.size() == answer.state_scale.data.size()) return answer;
  throw ProtocolError(fmt::format("participant '{}' told a state of {} numbers with {} scales", name(),
                                  answer.state.data.size(), answer.state_scale.data.size()));
}

void Link::post_advance(const Step& step, const std::vector<double>& input, Acceptance acceptance) {
  acceptance_ = acceptance;
  ends_window_ = step.ends_window;
  request_.kind = wire::Kind::advance;
  request_.window = step.accepted_window + 1;
  request_.windows = step.windows;
  request_.substep = step.substep;
  request_.accept_at_once = acceptance == Acceptance::at_once;
  request_.absolute_requested = step.absolute;
  request_.records_requested = step.records;
  set(request_.link_increment, input, rows_.components);
  trial_input_ = input;
  for (std::size_t i = 0; i < input.size(); ++i) {
    double& increment = request_.link_increment.data[i];
    increment -= received_input_[i];
    if (!step.absolute) trial_input_[i] = received_input_[i] + increment;
  }
  if (step.absolute) {
    set(request_.link_absolute, input, rows_.components);
  } else {
    clear(request_.link_absolute, rows_.components);
  }
  peer_.post(request_);
}

void Link::wait_advanced() {
  const auto& answer = wait(wire::Kind::advanced);
  require_rows(answer.increment, "increment");  // driven by displacement: Delta P
  for (std::size_t i = 0; i < output_.size(); ++i) output_[i] = output_accepted_[i] + answer.increment.data[i];
  if (answer.absolute.rows > 0) {
    require_rows(answer.absolute, "absolute");
    largest_drift_ = std::max(largest_drift_, wire::relative_difference(output_, answer.absolute.data));
    output_ = answer.absolute.data;
  }
  take_rates(answer);
  if (acceptance_ == Acceptance::at_once) take_acceptance(answer);
}

void Link::post_accept(const Step& step) {
  request_.kind = wire::Kind::accept;
  request_.window = step.accepted_window + 1;
  request_.substep = step.substep;
  request_.records_requested = step.records;
  peer_.post(request_);
}

void Link::wait_accepted() { take_acceptance(wait(wire::Kind::accepted)); }

void Link::take_acceptance(const wire::Message& answer) {
  received_input_.swap(trial_input_);
  output_accepted_ = output_;
  if (ends_window_) window_ = window_of(answer);
  contact_ = {answer.pairs_closed, answer.gap_min_m,         answer.gap_rate_min_m_s,
              answer.separated,    answer.separation_time_s, answer.finished_early};
  take_records_of(answer);
}

/// The window that an answer says it has come to: the one that was asked for, or of several the last, unless the run is
/// over.
std::int64_t Link::window_of(const wire::Message& answer) const {
  const auto last = request_.window + request_.windows - 1;
  const bool early = answer.finished_early && answer.window >= request_.window && answer.window < last;
  if (answer.window == last || early) return answer.window;
  throw ProtocolError(fmt::format("participant '{}' answered 'window' = {}, it was asked to compute windows {} to {}",
                                  name(), answer.window, request_.window, last));
}

void Link::post_finish() {
  request_.kind = wire::Kind::finish;
  peer_.post(request_);
}

const wire::Message& Link::wait_finished() {
  const auto& answer = wait(wire::Kind::finished);
  take_records_of(answer);
  largest_drift_ = std::max(largest_drift_, answer.largest_drift);
  return answer;
}

const wire::Message& Link::wait(wire::Kind expected) {
  const auto& answer = peer_.wait();
  if (answer.kind != expected) {
    throw ProtocolError(fmt::format("participant '{}' answered '{}' in window {}, expected '{}'", name(),
                                    wire::name(answer.kind), request_.window, wire::name(expected)));
  }
  return answer;
}

void Link::take_absolute(const wire::Message& answer) {
  require_rows(answer.absolute, "absolute");
  output_ = answer.absolute.data;
  output_accepted_ = output_;
}

void Link::take_rates(const wire::Message& answer) {
  if (!driven_by_force_ || answer.velocity_m_s.rows == 0) return;
  require_rows(answer.velocity_m_s, "velocity_m_s");
  require_rows(answer.acceleration_m_s2, "acceleration_m_s2");
  velocity_.assign(answer.velocity_m_s.data.begin(), answer.velocity_m_s.data.end());
  acceleration_.assign(answer.acceleration_m_s2.data.begin(), answer.acceleration_m_s2.data.end());
}

void Link::require_body(double body, const char* field) const {
  if (body >= 0 && body < static_cast<double>(description_.bodies.size()) && body == std::floor(body)) return;
  throw ProtocolError(fmt::format("participant '{}' named body {} in '{}', it has {}", name(), body, field,
                                  description_.bodies.size()));
}

void Link::take_departures(const wire::Message& answer) {
  const auto require_columns = [&](const wire::Array& array, int columns, const char* field) {
    if (array.rows == 0 || array.columns == columns) return;
    throw ProtocolError(fmt::format("participant '{}' sent '{}' with rows of {} numbers, expected {}", name(), field,
                                    array.columns, columns));
  };
  require_columns(answer.departures, wire::departure_columns, "departures");
  require_columns(answer.outline, 2 + rows_.components, "outline");
  for (int row = 0; row < answer.departures.rows; ++row) {
    const double* values = &answer.departures.data[static_cast<std::size_t>(row * wire::departure_columns)];
    if (!(values[0] >= 1 && values[0] <= departure_kinds && values[0] == std::floor(values[0]))) {
      throw ProtocolError(fmt::format("participant '{}' sent the unknown kind {} in 'departures'", name(), values[0]));
    }
    require_body(values[1], "departures");
  }
  for (int row = 0; row < answer.outline.rows; ++row) {
    require_body(answer.outline.data[static_cast<std::size_t>(row * answer.outline.columns)], "outline");
  }
  if (answer.departures.rows > 0) departures_ = answer.departures;  // what has left once stays told
  if (answer.outline.rows > 0) outline_ = answer.outline;
}

void Link::take_records_of(const wire::Message& answer) {
  take_departures(answer);
  const std::int64_t requested = request_.records_requested ? window_ : -1;
  records_.take(answer.records, name(), window_, requested);
  axial_stress_.take(answer.axial_stress, name(), window_, requested);
}

void Link::require_rows(const wire::Array& array, const char* field) const {
  if (array.rows == static_cast<int>(rows_.shared.size()) && array.columns == rows_.components) return;
  throw ProtocolError(
      fmt::format("participant '{}' answered window {} with {} x {} numbers in '{}', its interface has {} x {}", name(),
                  request_.window, array.rows, array.columns, field, rows_.shared.size(), rows_.components));
}

}  // namespace ricochet::coupler
