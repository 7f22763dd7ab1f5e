// The work of a session at each request of the coupler.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "common/base/names.hpp"
#include "common/participant/session.hpp"

namespace ricochet::participant {
namespace {

/// The text is made only if it is needed: the stepping loop comes by here.
template <class... Values>
void require(bool holds, fmt::format_string<Values...> text, Values&&... values) {
  if (!holds) throw ProtocolError(fmt::format(text, std::forward<Values>(values)...));
}

/// The number or name that the coupler named; `asked` says how it asked.
template <class E>
E named(std::string_view asked, const std::string& text) {
  const auto found = find_named<E>(text);
  if (found) return *found;
  const auto names = all_names<E>();
  throw ProtocolError(fmt::format("the coupler {} '{}', expected one of '{}'{}", asked, text, fmt::join(names, "', '"),
                                  did_you_mean(text, names)));
}

void require_count(const char* field, std::int64_t value, int least) {
  constexpr int most = std::numeric_limits<int>::max();
  require(value >= least && value <= most, "the coupler set {} = {}, expected {} to {}", field, value, least, most);
}

void check_size(double window_size_s) {
  require(window_size_s > 0, "the coupler set window_size_s = {}, expected > 0", window_size_s);
}

void check_setup(const wire::Initialize& request) {
  check_size(request.window_size_s);
  require_count("history_every", request.history_every, 1);
  require_count("fields_every", request.fields_every, 0);
  require_count("axial_stress_every", request.axial_stress_every, 0);
  require_count("probes_every", request.probes_every, 0);
  require_count("separation_windows", request.separation_windows, 0);
  require_count("substeps", request.substeps, 1);
  require(request.last_window >= 0, "the coupler set last_window = {}, expected >= 0", request.last_window);
}

Drive drive_of(const std::string& text, const Description& description, bool can_be_forced) {
  const auto drive = named<Drive>("drives by", text);
  const bool implicit = description.role == Role::implicit_solver;
  require(drive == Drive::force ? implicit || can_be_forced : !implicit,
          "the coupler drives {} participant '{}' by {}, which it is not made for", name_of(description.role),
          description.name, text);
  return drive;
}

}  // namespace

void Session::describe(wire::Description& reply) const {
  const auto& d = description_;
  reply.components = d.components;
  reply.bodies = d.bodies;
  reply.interface_body.resize(nodes_, 1);
  std::copy(d.interface_body.begin(), d.interface_body.end(), reply.interface_body.data.begin());
  reply.interface_position_m.set(d.interface_position_m, nodes_, d.components);
  reply.interface_mass_kg.set(d.interface_mass_kg, nodes_, 1);
  reply.critical_time_step_s = d.critical_time_step_s;
  for (const auto capability : d.capabilities) reply.capabilities.emplace_back(name_of(capability));
  reply.record_columns = d.record_columns;
  reply.axial_stress_columns = d.axial_stress_columns;
  reply.probe_columns = d.probe_columns;
  reply.contact_owner = d.contact_owner;
}

void Session::initialize(const wire::Initialize& request, wire::Initialized& reply) {
  check_setup(request);
  require_rows(request.interface_mass_kg, "interface_mass_kg", 1);
  setup_.run_id = run_id_;
  setup_.protocol = request.protocol;
  setup_.output_directory = request.output_directory;
  setup_.clock = request.window_size_s;
  setup_.interface_mass_kg = request.interface_mass_kg.data;
  setup_.substeps = static_cast<int>(request.substeps);
  setup_.driven_by = drive_of(request.driven_by, description_, can(Capability::driven_by_force));
  moves_ = setup_.driven_by == Drive::force;
  take_interface_stiffness(request.interface_stiffness);
  take_places(request);
  setup_.history_every = static_cast<int>(request.history_every);
  setup_.fields_every = static_cast<int>(request.fields_every);
  setup_.axial_stress_every = static_cast<int>(request.axial_stress_every);
  setup_.probes_every = static_cast<int>(request.probes_every);
  setup_.until_separated_plus_s = request.until_separated_plus_s;
  setup_.separation_windows = static_cast<int>(request.separation_windows);
  setup_.last_window = request.last_window;
  const auto begin = std::chrono::steady_clock::now();
  participant_.initialize(setup_, output_);
  reply.setup_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  require_output(false);
  put_absolute(reply.absolute);
}

void Session::take_interface_stiffness(const wire::Array& stiffness) {
  const int size = nodes_ * description_.components;
  require(
      stiffness.rows == 0 || (stiffness.rows == size && stiffness.columns == size),
      "the coupler sent 'interface_stiffness' with {} x {} numbers, the interface of participant '{}' needs {} x {}",
      stiffness.rows, stiffness.columns, description_.name, size, size);
  require(stiffness.rows == 0 || can(Capability::interface_stiffness),
          "the coupler sent an interface stiffness, but participant '{}' lacks the capability 'interface_stiffness'",
          description_.name);
  setup_.interface_stiffness = stiffness.data;
}

void Session::take_places(const wire::Initialize& request) {
  const int components = description_.components;
  require(request.directions.rows == components && request.directions.columns == components,
          "the coupler sent 'directions' with {} x {} numbers, expected {} x {}", request.directions.rows,
          request.directions.columns, components, components);
  require_rows(request.scene_position_m, "scene_position_m", components);
  setup_.directions = request.directions.data;
  setup_.scene_position_m = request.scene_position_m.data;
}

void Session::synchronise(const wire::Synchronise& request, wire::Synchronised& reply) {
  const auto integration = named<Integration>("asked for the integration", request.integration);
  require_rows(request.link_absolute, "link_absolute", description_.components);
  link_.set_input(request.link_absolute);
  tried_ = false;
  participant_.synchronise(integration, link_.input(), output_);
  synchronised_ = true;
  require_output(true);
  link_.set_output(output_.value);
  put_absolute(reply.absolute);
  put_rates(reply);
  if (accepted_window_ > 0) return;
  rows_.clear();  // the coupler may synchronise the start more than once
  stress_rows_.clear();
  probe_rows_.clear();
  record_due_ = true;
  stress_due_ = wants_axial_stress(0);
  probes_due_ = wants_probes(0);
  fields_due_ = setup_.fields_every > 0;
}

void Session::reconfigure(const wire::Reconfigure& request) {
  require(can(Capability::reconfigure),
          "the coupler asked for windows of another size, but participant '{}' lacks the capability 'reconfigure'",
          description_.name);
  check_size(request.window_size_s);
  require(accepted_substep_ == 0, "the coupler changed the size of window {}, of which substep {} is accepted",
          accepted_window_ + 1, accepted_substep_);
  setup_.clock.change(accepted_window_, request.window_size_s);
  take_interface_stiffness(request.interface_stiffness);
  participant_.reconfigure(setup_);
}

void Session::check_advance(const wire::Header& header, const wire::Advance& request) const {
  const auto next = accepted_window_ + 1;
  require(header.window == next, "the coupler asked for window {}, the next one is window {}", header.window, next);
  check_substep(header, request.windows);
  require(next <= setup_.last_window, "the coupler asked for window {}, the last one is window {}", next,
          setup_.last_window);
  require(request.windows >= 1, "the coupler asked for {} windows, expected >= 1", request.windows);
  require(request.windows == 1 || (nodes_ == 0 && request.accept_at_once),
          "the coupler asked for {} windows at once: that needs a participant without interface nodes (this one "
          "has {}) and accept_at_once",
          request.windows, nodes_);
  require(!tried_ || can_repeat_,
          "the coupler asked to repeat window {}, but participant '{}' lacks the "
          "capability 'repeat_window'",
          next, description_.name);
  require_rows(request.link_increment, "link_increment", description_.components);
  if (request.link_absolute.rows != 0) require_rows(request.link_absolute, "link_absolute", description_.components);
}

void Session::check_substep(const wire::Header& header, std::int64_t windows) const {
  if (header.substep == 0) {
    require(accepted_substep_ == 0, "the coupler asked for the whole window {}, of which substep {} is accepted",
            header.window, accepted_substep_);
    return;
  }
  require(can(Capability::single_substep),
          "the coupler asked for substep {}, but participant '{}' lacks the capability 'single_substep'",
          header.substep, description_.name);
  require(setup_.driven_by == Drive::force,
          "the coupler asked for substep {}, but drives participant '{}' by displacement", header.substep,
          description_.name);
  require(header.substep == accepted_substep_ + 1 && header.substep <= setup_.substeps && windows == 1,
          "the coupler asked for substep {} of {} in window {}, the next one is substep {}", header.substep,
          setup_.substeps, header.window, accepted_substep_ + 1);
}

void Session::advance(const wire::Header& header, const wire::Advance& request, wire::Advanced& reply) {
  check_advance(header, request);
  const auto last = accepted_window_ + std::min(request.windows, setup_.last_window - accepted_window_);
  link_.receive(request.link_increment, request.link_absolute);
  substep_ = header.substep;
  touching_ = request.touching;
  do {
    window_ = accepted_window_ + 1;
    if (substep_ == 0) {
      participant_.advance(window_, link_.input(), output_);
    } else {
      participant_.advance_substep(window_, static_cast<int>(substep_), link_.input(), output_);
    }
    require_output(true);
    link_.send(output_.value, request.absolute_requested, reply.increment, reply.absolute);
    tried_ = true;
    if (request.accept_at_once) accept_trial();
    if (request.windows > 1) {
      finish_window();
      touching_ = contact_.pairs_closed > 0;
    }
  } while (request.accept_at_once && window_ < last && !contact_.finished);
  put_rates(reply);
  put_accepted_window(request.records_requested, reply);
}

void Session::accept(const wire::Header& header, const wire::Accept& request, wire::Accepted& reply) {
  require(header.window == window_, "the coupler accepted window {}, the trial was of window {}", header.window,
          window_);
  accept_trial();
  put_accepted_window(request.records_requested, reply);
}

/// Only the contact's state is needed in the reply; everything else can wait until that is on its way.
void Session::accept_trial() {
  link_.accept();
  tried_ = false;
  accept_due_ = true;
  const bool whole = substep_ == 0 || substep_ == setup_.substeps;
  accepted_substep_ = whole ? 0 : substep_;
  if (!whole) return;
  accepted_window_ = window_;
  participant_.note_touch(touching_);
  record_due_ = window_ % setup_.history_every == 0;
  stress_due_ = wants_axial_stress(window_);
  probes_due_ = wants_probes(window_);
  fields_due_ = setup_.fields_every > 0 && (window_ % setup_.fields_every == 0 || window_ == setup_.last_window);
  if (description_.contact_owner) accept();
}

void Session::accept() {
  if (!std::exchange(accept_due_, false)) return;
  participant_.accept();
  contact_ = participant_.contact_status();
  if (accepted_substep_ == 0) record_contact_forces();
}

void Session::finish_window() {
  accept();
  if (std::exchange(record_due_, false)) record();
  if (std::exchange(stress_due_, false)) record_axial_stress();
  if (std::exchange(probes_due_, false)) record_probes();
  if (std::exchange(fields_due_, false)) write_fields();
}

void Session::load_state(const wire::LoadState& request) {
  require(can(Capability::load_state),
          "the coupler asked to load a state, but participant '{}' lacks the capability 'load_state'",
          description_.name);
  const auto contact = named<FrozenContact>("asked for the frozen contact", request.frozen_contact);
  std::vector<double> state, scale;
  participant_.read_state(state, scale);
  require(request.state.data.size() == state.size() && request.state.columns == 1,
          "the coupler sent 'state' with {} x {} numbers, that of participant '{}' has {} x 1", request.state.rows,
          request.state.columns, description_.name, state.size());
  participant_.load_state(request.state.data, contact);
}

void Session::read_state(wire::State& reply) {
  require(can(Capability::load_state),
          "the coupler asked for a state, but participant '{}' lacks the capability 'load_state'", description_.name);
  std::vector<double> state, scale;
  participant_.read_state(state, scale);
  const bool positive = std::all_of(scale.begin(), scale.end(), [](double x) { return x > 0.0; });
  if (scale.size() != state.size() || !positive) {
    throw ParticipantError(
        fmt::format("participant '{}' told a state of {} numbers with {} scales, expected as many, "
                    "each > 0",
                    description_.name, state.size(), scale.size()));
  }
  reply.state.set(state, static_cast<int>(state.size()), 1);
  reply.state_scale.set(scale, static_cast<int>(scale.size()), 1);
}

void Session::finish(wire::Finished& reply) {
  if (setup_.fields_every > 0 && fields_window_ != accepted_window_)
    write_fields();  // the run ended before its last window
  participant_.finish();
  reply.largest_drift = link_.largest_drift();
  put_records(true, reply);
}

void Session::write_fields() {
  participant_.write_fields(accepted_window_);
  fields_window_ = accepted_window_;
}

void Session::require_rows(const wire::Array& array, std::string_view field, int columns) const {
  require(array.rows == nodes_ && array.columns == columns,
          "the coupler sent '{}' with {} x {} numbers, the interface of participant '{}' has {} x {}", field,
          array.rows, array.columns, description_.name, nodes_, columns);
}

void Session::require_output(bool rates_needed) const {
  const auto check = [&](const std::vector<double>& values, std::string_view what, bool may_be_full,
                         bool may_be_empty) {
    if ((may_be_full && values.size() == link_.size()) || (may_be_empty && values.empty())) return;
    throw ParticipantError(fmt::format("participant '{}' ({}) answered with {} numbers as {}, expected {}",
                                       description_.name, name_of(description_.role), values.size(), what,
                                       may_be_full ? link_.size() : 0));
  };
  check(output_.value, name_of(moves_ ? Drive::displacement : Drive::force), true, false);
  check(output_.velocity_m_s, "velocity_m_s", moves_, !moves_ || !rates_needed);
  check(output_.acceleration_m_s2, "acceleration_m_s2", moves_, !moves_ || !rates_needed);
}

}  // namespace ricochet::participant
