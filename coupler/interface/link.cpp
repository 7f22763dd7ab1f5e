#include "coupler/interface/link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

/// Kinds of `departures`, from 1 on.
constexpr double departure_kinds = 8;

/// The number of contacts that the owner tells the forces of: those that its history columns are of, or the one there
/// is.
std::size_t contacts_of(const PeerDescription& description) {
  std::size_t named = 0;
  for (const auto& column : description.record_columns) named += column.rfind("contact_force_n/", 0) == 0 ? 1 : 0;
  return std::max<std::size_t>(named, 1);
}

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

Link::Link(Peer peer, const PeerDescription& description, const InterfaceRows& rows)
    : peer_(std::move(peer)),
      description_(description),
      rows_(rows),
      records_("records", "history row", description.record_columns.size()),
      axial_stress_("axial_stress", "axial stress row", description.axial_stress_columns.size()),
      probes_("probes", "probe row", description.probe_columns.size()),
      contact_forces_("contact_forces", "contact forces", 1 + contacts_of(description)) {
  const std::size_t size = rows_.nodes() * static_cast<std::size_t>(rows_.components());
  for (auto* values : {&received_input_, &trial_input_, &output_accepted_, &output_}) values->assign(size, 0.0);
}

template <class Body>
Body& Link::wait() {
  auto& answer = peer_.wait();
  if (answer.kind != Body::kind) {
    throw ProtocolError(fmt::format("participant '{}' answered '{}' in window {}, expected '{}'", name(),
                                    wire::name(answer.kind), request_.window, wire::name(Body::kind)));
  }
  answer_window_ = answer.window;
  return answer.template as<Body>();
}

std::vector<double> Link::own_mass_kg() const {
  std::vector<double> masses;
  for (const double mass : description_.interface_mass_kg.data) {
    masses.insert(masses.end(), static_cast<std::size_t>(rows_.components()), mass);
  }
  return masses;
}

void Link::post_initialize(wire::Initialize request, const std::vector<double>& own_masses) {
  records_.expect_every(request.history_every);
  axial_stress_.expect_every(request.axial_stress_every);
  probes_.expect_every(request.probes_every);
  contact_forces_.expect_every(description_.contact_owner ? 1 : 0, 1);
  if (request.driven_by.empty()) request.driven_by = name_of(implicit() ? Drive::force : Drive::displacement);
  driven_by_force_ = request.driven_by == name_of(Drive::force);
  if (description_.substeps > 0) request.substeps = description_.substeps;
  set(request.interface_mass_kg, own_masses, 1);
  const auto& places = description_.scene_position_m;
  set(request.scene_position_m, places.empty() ? description_.interface_position_m.data : places, rows_.components());
  request_.make<wire::Initialize>() = std::move(request);
  peer_.post(request_);
}

void Link::wait_initialized() {
  const auto& answer = wait<wire::Initialized>();
  setup_s_ = answer.setup_s;
  take_absolute(answer.absolute);
}

void Link::post_synchronise(Integration integration, const std::vector<double>& input) {
  received_input_ = input;
  auto& request = request_.make<wire::Synchronise>();
  request.integration = name_of(integration);
  set(request.link_absolute, received_input_, rows_.components());
  peer_.post(request_);
}

void Link::wait_synchronised() {
  auto& answer = wait<wire::Synchronised>();
  take_absolute(answer.absolute);
  take_rates(answer);
}

void Link::post_reconfigure(double window_size_s, const Eigen::MatrixXd& stiffness) {
  auto& request = request_.make<wire::Reconfigure>();
  request_.window = window_;
  request.window_size_s = window_size_s;
  request.interface_stiffness.resize(static_cast<int>(stiffness.rows()), static_cast<int>(stiffness.cols()));
  std::copy_n(stiffness.data(), stiffness.size(), request.interface_stiffness.data.begin());
  peer_.post(request_);
}

void Link::wait_reconfigured() { wait<wire::Reconfigured>(); }

void Link::post_load_state(const std::vector<double>& state, FrozenContact frozen_contact) {
  auto& request = request_.make<wire::LoadState>();
  request.frozen_contact = name_of(frozen_contact);
  set(request.state, state, 1);
  peer_.post(request_);
}

void Link::wait_state_loaded() { wait<wire::StateLoaded>(); }

void Link::post_read_state() {
  request_.make<wire::ReadState>();
  peer_.post(request_);
}

const wire::State& Link::wait_state() {
  const auto& answer = wait<wire::State>();
  if (answer.state.data.size() == answer.state_scale.data.size()) return answer;
  throw ProtocolError(fmt::format("participant '{}' told a state of {} numbers with {} scales", name(),
                                  answer.state.data.size(), answer.state_scale.data.size()));
}

void Link::post_save_state() {
  request_.make<wire::SaveState>();
  request_.window = window_;
  peer_.post(request_);
}

const std::string& Link::wait_saved_state() { return wait<wire::SavedState>().saved.data; }

void Link::post_restore_state(const std::string& saved) {
  request_.make<wire::RestoreState>().saved.data = saved;
  request_.window = 0;
  peer_.post(request_);
}

void Link::wait_state_restored() { wait<wire::StateRestored>(); }

void Link::archive(Archive& a) {
  const auto size = output_.size();
  a(received_input_, output_, velocity_, acceleration_, contact_, departures_, outline_, largest_drift_, window_,
    records_, axial_stress_, probes_, contact_forces_);
  if (received_input_.size() != size || output_.size() != size) a.refuse("another interface");
  trial_input_ = received_input_;
  output_is_accepted_ = true;
}

void Link::post_advance(const Step& step, const std::vector<double>& input, Acceptance acceptance) {
  acceptance_ = acceptance;
  ends_window_ = step.ends_window;
  auto& request = request_.make<wire::Advance>();
  request_.window = step.accepted_window + 1;
  request_.substep = step.substep;
  last_requested_ = step.accepted_window + step.windows;
  records_requested_ = step.records;
  request.windows = step.windows;
  request.accept_at_once = acceptance == Acceptance::at_once;
  request.absolute_requested = absolute_requested_ = step.absolute;
  request.records_requested = step.records;
  request.touching = step.touching;
  request.link_increment.resize(static_cast<int>(rows_.nodes()), rows_.components());
  for (std::size_t i = 0; i < input.size(); ++i) {
    const double increment = input[i] - received_input_[i];
    request.link_increment.data[i] = increment;
    trial_input_[i] = step.absolute ? input[i] : received_input_[i] + increment;
  }
  if (step.absolute) {
    set(request.link_absolute, input, rows_.components());
  } else {
    clear(request.link_absolute, rows_.components());
  }
  peer_.post(request_);
}

void Link::wait_advanced() {
  auto& answer = wait<wire::Advanced>();
  require_rows(answer.increment, "increment");  // driven by displacement: Delta P
  if (std::exchange(output_is_accepted_, false)) output_accepted_.swap(output_);
  for (std::size_t i = 0; i < output_.size(); ++i) output_[i] = output_accepted_[i] + answer.increment.data[i];
  require_asked_for(answer.absolute, absolute_requested_, "absolute");
  if (absolute_requested_) {
    require_rows(answer.absolute, "absolute");
    largest_drift_ = std::max(largest_drift_, wire::relative_difference(output_, answer.absolute.data));
    output_ = answer.absolute.data;
  }
  take_rates(answer);
  if (acceptance_ == Acceptance::at_once) take_acceptance(answer);
}

void Link::post_accept(const Step& step) {
  request_.make<wire::Accept>().records_requested = step.records;
  request_.window = last_requested_ = step.accepted_window + 1;
  request_.substep = step.substep;
  records_requested_ = step.records;
  peer_.post(request_);
}

void Link::wait_accepted() { take_acceptance(wait<wire::Accepted>()); }

void Link::take_acceptance(const wire::AcceptedWindow& answer) {
  received_input_.swap(trial_input_);
  output_is_accepted_ = true;
  if (ends_window_) window_ = answered_window(answer.finished_early);
  require_no_contact_of_others(answer);
  contact_ = static_cast<const wire::ContactReport&>(answer);
  require_asked_for(answer.outline, records_requested_, "outline");
  take_outline(answer.outline);
  take_records_of(answer, records_requested_);
}

/// The window that an answer says it has come to: the one that was asked for, or of several the last, unless the run is
/// over.
std::int64_t Link::answered_window(bool finished_early) const {
  const bool early = finished_early && answer_window_ >= request_.window && answer_window_ < last_requested_;
  if (answer_window_ == last_requested_ || early) return answer_window_;
  throw ProtocolError(fmt::format("participant '{}' answered 'window' = {}, it was asked to compute windows {} to {}",
                                  name(), answer_window_, request_.window, last_requested_));
}

void Link::post_finish() {
  request_.make<wire::Finish>();
  peer_.post(request_);
}

const wire::Finished& Link::wait_finished() {
  const auto& answer = wait<wire::Finished>();
  take_records_of(answer, true);
  largest_drift_ = std::max(largest_drift_, answer.largest_drift);
  return answer;
}

void Link::take_absolute(const wire::Array& absolute) {
  require_rows(absolute, "absolute");
  output_ = absolute.data;
  output_is_accepted_ = true;
}

void Link::take_rates(wire::Rates& answer) {
  require_asked_for(answer.velocity_m_s, driven_by_force_, "velocity_m_s");
  require_asked_for(answer.acceleration_m_s2, driven_by_force_, "acceleration_m_s2");
  if (!driven_by_force_ || answer.velocity_m_s.rows == 0) return;
  require_rows(answer.velocity_m_s, "velocity_m_s");
  require_rows(answer.acceleration_m_s2, "acceleration_m_s2");
  velocity_.swap(answer.velocity_m_s.data);
  acceleration_.swap(answer.acceleration_m_s2.data);
}

/// An array that nobody asked for is no harmless extra: a sender of it means something else by its messages.
void Link::require_asked_for(const wire::Array& array, bool asked_for, const char* field) const {
  if (asked_for || array.rows == 0) return;
  throw ProtocolError(
      fmt::format("participant '{}' sent {} rows in '{}' of window {}, expected 0 rows: nobody asked for it", name(),
                  array.rows, field, request_.window));
}

void Link::require_no_contact_of_others(const wire::ContactReport& report) const {
  if (description_.contact_owner || report == wire::ContactReport{}) return;
  throw ProtocolError(fmt::format(
      "participant '{}' reported a contact in window {} (pairs_closed = {}, gap_min_m = {}, gap_rate_min_m_s "
      "= {}, separated = {}, separation_time_s = {}, finished_early = {}), which it does not own: expected "
      "are 0, false and a separation time of -1",
      name(), request_.window, report.pairs_closed, report.gap_min_m, report.gap_rate_min_m_s, report.separated,
      report.separation_time_s, report.finished_early));
}

void Link::require_body(double body, const char* field) const {
  if (body >= 0 && body < static_cast<double>(description_.bodies.size()) && body == std::floor(body)) return;
  throw ProtocolError(fmt::format("participant '{}' named body {} in '{}', it has {}", name(), body, field,
                                  description_.bodies.size()));
}

void Link::require_columns(const wire::Array& array, int columns, const char* field) const {
  if (array.rows == 0 || array.columns == columns) return;
  throw ProtocolError(fmt::format("participant '{}' sent '{}' with rows of {} numbers, expected {}", name(), field,
                                  array.columns, columns));
}

void Link::take_departures(const wire::Array& departures) {
  require_columns(departures, wire::departure_columns, "departures");
  for (int row = 0; row < departures.rows; ++row) {
    const double* values = &departures.data[static_cast<std::size_t>(row * wire::departure_columns)];
    if (!(values[0] >= 1 && values[0] <= departure_kinds && values[0] == std::floor(values[0]))) {
      throw ProtocolError(fmt::format("participant '{}' sent the unknown kind {} in 'departures'", name(), values[0]));
    }
    require_body(values[1], "departures");
  }
  if (departures.rows > 0) departures_ = departures;  // what has left once stays told
}

void Link::take_outline(const wire::Array& outline) {
  require_columns(outline, 2 + rows_.components(), "outline");
  for (int row = 0; row < outline.rows; ++row) {
    require_body(outline.data[static_cast<std::size_t>(row * outline.columns)], "outline");
  }
  if (outline.rows > 0) outline_ = outline;
}

void Link::take_records_of(const wire::Records& answer, bool asked_for) {
  require_asked_for(answer.departures, asked_for, "departures");
  take_departures(answer.departures);
  const std::int64_t requested = records_requested_ ? window_ : -1;
  records_.take(answer.records, name(), window_, requested);
  axial_stress_.take(answer.axial_stress, name(), window_, requested);
  probes_.take(answer.probes, name(), window_, requested);
  require_asked_for(answer.records, asked_for, "records");
  require_asked_for(answer.axial_stress, asked_for, "axial_stress");
  require_asked_for(answer.probes, asked_for, "probes");
  require_asked_for(answer.contact_forces, asked_for, "contact_forces");
  if (answer.contact_forces.rows > 0) contact_forces_.take(answer.contact_forces, name(), window_, requested);
}

void Link::require_rows(const wire::Array& array, const char* field) const {
  if (array.rows == static_cast<int>(rows_.nodes()) && array.columns == rows_.components()) return;
  throw ProtocolError(
      fmt::format("participant '{}' answered window {} with {} x {} numbers in '{}', its interface has {} x {}", name(),
                  request_.window, array.rows, array.columns, field, rows_.nodes(), rows_.components()));
}

}  // namespace ricochet::coupler
