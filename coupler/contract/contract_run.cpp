#include "coupler/contract/contract_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/results/axial_stress.hpp"
#include "coupler/results/history.hpp"

namespace ricochet::coupler {
namespace {

void require(bool holds, const std::string& text) {
  if (!holds) throw ProtocolError(text);
}

/// Asks, and takes the answer as one of that kind: the order of messages lets no other through.
template <class Answer, class Request>
const Answer& ask(ContractPeer& peer, Request request, std::int64_t window = 0) {
  wire::Message message;
  message.make<Request>() = std::move(request);
  message.window = window;
  return peer.ask(message).template as<Answer>();
}

void check_interface(const wire::Description& d) {
  const int count = d.interface_position_m.rows;
  require(d.components >= 1 && d.components <= 3,
          fmt::format("it has {} components, allowed are 1 to 3", d.components));
  require(d.interface_position_m.columns == d.components && d.interface_body.rows == count &&
              d.interface_body.columns == 1 && d.interface_mass_kg.rows == count && d.interface_mass_kg.columns == 1,
          fmt::format("it has {} x {} positions, {} x {} masses and {} x {} body numbers for {} components", count,
                      d.interface_position_m.columns, d.interface_mass_kg.rows, d.interface_mass_kg.columns,
                      d.interface_body.rows, d.interface_body.columns, d.components));
  for (int i = 0; i < count; ++i) {
    const double mass = d.interface_mass_kg.data[static_cast<std::size_t>(i)];
    const double body = d.interface_body.data[static_cast<std::size_t>(i)];
    require(mass > 0.0, fmt::format("interface node {} has the mass {} kg, expected more than 0", i, mass));
    require(body >= 0.0 && body < static_cast<double>(d.bodies.size()) && body == std::floor(body),
            fmt::format("interface node {} has the body number {}, it has {} bodies", i, body, d.bodies.size()));
  }
}

void check_description(const wire::Hello& hello, const wire::Description& d) {
  require(!hello.participant.empty(), "it has no name");
  require(find_named<Role>(hello.role).has_value(),
          fmt::format("its role is '{}', allowed are '{}'", hello.role, fmt::join(all_names<Role>(), "', '")));
  check_interface(d);
  require(d.critical_time_step_s >= 0.0, fmt::format("its critical time step is {} s", d.critical_time_step_s));
  for (const auto& capability : d.capabilities) {
    require(find_named<Capability>(capability).has_value(),
            fmt::format("it has the unknown capability '{}'{}", capability,
                        did_you_mean(capability, all_names<Capability>())));
  }
  const History names_columns_rightly({{hello.participant, d.record_columns}}, d.bodies, {},
                                      contacts_named_in(d.record_columns));
  const AxialStress names_layers_rightly({{hello.participant, d.axial_stress_columns}}, d.bodies);
}

/// Largest extent of the interface [m]; for a single point its distance from the origin, or 1 m there.
double length_scale(const wire::Description& d) {
  double scale = 0.0;
  for (int c = 0; c < d.interface_position_m.columns; ++c) {
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < d.interface_position_m.rows; ++i) {
      const double x = d.interface_position_m.data[static_cast<std::size_t>(i * d.interface_position_m.columns + c)];
      low = std::min(low, x);
      high = std::max(high, x);
    }
    scale = std::max({scale, high - low, d.interface_position_m.rows == 1 ? std::abs(high) : 0.0});
  }
  return scale > 0.0 ? scale : 1.0;
}

/// Link input at the end of a window; `other`: a different one, for trials that are thrown away.
std::vector<double> input_at(const ContractRun& run, const ContractDrive& drive, int window, bool other) {
  const auto& d = run.description;
  std::vector<double> input(run.size(), 0.0);
  if (!drive.inputs.empty()) {
    std::copy_n(drive.inputs.begin() + static_cast<std::ptrdiff_t>(input.size()) * window, input.size(), input.begin());
    return input;
  }
  if (drive.zero_input && !other) return input;
  const double displacement = 1e-6 * length_scale(d), long_window_s = drive.fine * run.window_size_s;
  const int last = drive.windows / drive.fine, before = window / drive.fine;
  const double share = static_cast<double>(window % drive.fine) / drive.fine;
  for (std::size_t i = 0; i < input.size(); ++i) {
    const double phase = 1.3 * static_cast<double>(i) + (other ? 0.9 : 0.0);
    const auto shape = [&](int n) { return n * std::sin(0.5 * n + phase) / last; };
    const double mass = d.interface_mass_kg.data[i / static_cast<std::size_t>(d.components)];
    const double size = run.by_force ? mass * displacement / (long_window_s * long_window_s) : displacement;
    input[i] = size * ((1.0 - share) * shape(before) + (share > 0.0 ? share * shape(before + 1) : 0.0));
  }
  return input;
}

void append(const std::vector<double>& values, std::vector<double>& to) {
  to.insert(to.end(), values.begin(), values.end());
}

void take_rates(const wire::Rates& answer, wire::Kind kind, ContractRun& run) {
  const std::size_t expected = run.by_force ? run.size() : 0;
  for (const auto* rates : {&answer.velocity_m_s, &answer.acceleration_m_s2}) {
    require(rates->data.size() == expected, fmt::format("'{}' has {} velocities or accelerations, expected {}",
                                                        wire::name(kind), rates->data.size(), expected));
  }
  append(answer.velocity_m_s.data, run.velocity);
  append(answer.acceleration_m_s2.data, run.acceleration);
}

std::vector<double> output_of(const wire::Array& array, const char* field, const ContractRun& run) {
  require(array.data.size() == run.size() && array.columns == run.description.components,
          fmt::format("its '{}' has {} x {} numbers, its interface has {} x {}", field, array.rows, array.columns,
                      run.description.interface_position_m.rows, run.description.components));
  return array.data;
}

wire::Initialize initialize_request(const ContractRun& run, const ContractDrive& drive) {
  wire::Initialize message;
  message.protocol = "hughes_liu";
  message.window_size_s = drive.begin_with_s > 0 ? drive.begin_with_s : run.window_size_s;
  message.driven_by = name_of(run.by_force ? Drive::force : Drive::displacement);
  message.substeps = drive.substeps;
  message.interface_mass_kg = run.description.interface_mass_kg;
  message.scene_position_m = run.description.interface_position_m;
  const auto components = static_cast<int>(run.description.components);
  message.directions = directions_along(Eigen::Vector3d::Unit(components - 1), components);  // as without a contact
  if (!drive.by_force) {
    for (double& mass : message.interface_mass_kg.data) mass *= 2.0;  // as if another of its kind shared the nodes
  }
  if (!drive.interface_stiffness.empty()) {
    const int size = static_cast<int>(run.size());
    message.interface_stiffness.resize(size, size);
    message.interface_stiffness.data = drive.interface_stiffness;
  }
  message.until_separated_plus_s = -1.0;
  message.separation_windows = 10;
  message.last_window = drive.windows;
  return message;
}

std::vector<double> last_input(const ContractRun& run) {
  return {run.input.end() - static_cast<std::ptrdiff_t>(run.size()), run.input.end()};
}

/// One `advance` from one link input to the next.
const wire::Advanced& advance_by(ContractPeer& peer, const ContractRun& run, int window,
                                 const std::vector<double>& last, const std::vector<double>& input,
                                 bool accept_at_once) {
  wire::Advance message;
  message.link_increment = run.description.interface_position_m;
  for (std::size_t i = 0; i < input.size(); ++i) message.link_increment.data[i] = input[i] - last[i];
  message.link_absolute.resize(0, static_cast<int>(run.description.components));
  message.accept_at_once = accept_at_once;
  return ask<wire::Advanced>(peer, std::move(message), window);
}

/// The substeps of a window one after the other, the link input linear between its ends; the answer is the last one's.
wire::Advanced advance_one_by_one(ContractPeer& peer, const ContractDrive& drive, const ContractRun& run, int window,
                                  const std::vector<double>& last, const std::vector<double>& input) {
  wire::Advanced answer;
  std::vector<double> increment(input.size(), 0.0);
  for (int substep = 1; substep <= drive.substeps; ++substep) {
    wire::Message request;
    auto& advance = request.make<wire::Advance>();
    request.window = window;
    request.substep = substep;
    advance.link_increment = run.description.interface_position_m;
    for (std::size_t i = 0; i < input.size(); ++i)
      advance.link_increment.data[i] = (input[i] - last[i]) / drive.substeps;
    advance.link_absolute.resize(0, static_cast<int>(run.description.components));
    advance.accept_at_once = true;
    answer = peer.ask(request).as<wire::Advanced>();
    const auto change = output_of(answer.increment, "increment", run);
    for (std::size_t i = 0; i < change.size(); ++i) increment[i] += change[i];
  }
  answer.increment.data = increment;
  return answer;
}

bool same_answer(const wire::Advanced& a, const wire::Advanced& b) {
  return a.increment.data == b.increment.data && a.velocity_m_s.data == b.velocity_m_s.data &&
         a.acceleration_m_s2.data == b.acceleration_m_s2.data;
}

void one_window(ContractPeer& peer, const ContractDrive& drive, int window, ContractRun& run) {
  const auto input = input_at(run, drive, window, false), last = last_input(run);
  const wire::Advanced answer = drive.one_by_one ? advance_one_by_one(peer, drive, run, window, last, input)
                                                 : advance_by(peer, run, window, last, input, !drive.try_first);
  if (drive.try_first) {
    advance_by(peer, run, window, last, input_at(run, drive, window, true), false);
    const wire::Advanced again = advance_by(peer, run, window, last, input, false);
    if (!same_answer(answer, again)) run.forgotten.push_back(window);
    ask<wire::Accepted>(peer, wire::Accept{}, window);
  }
  auto output = output_of(answer.increment, "increment", run);
  for (std::size_t i = 0; i < output.size(); ++i) output[i] += run.output[run.output.size() - output.size() + i];
  append(input, run.input);
  run.output.insert(run.output.end(), output.begin(), output.end());
  take_rates(answer, wire::Advanced::kind, run);
}

}  // namespace

void fail(const std::string& text) { throw ProtocolError(text); }

std::vector<double> ContractRun::column(const std::string& name) const {
  const auto& columns = description.record_columns;
  std::vector<std::size_t> indices;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c] == name || columns[c].rfind(name + "/", 0) == 0) indices.push_back(c);
  }
  std::vector<double> sum(indices.empty() ? 0 : records.size() / columns.size(), 0.0);
  for (std::size_t row = 0; row < sum.size(); ++row) {
    for (const auto c : indices) sum[row] += records[row * columns.size() + c];
  }
  return sum;
}

void describe(ContractPeer& peer, double timeout_s, ContractRun& run) {
  run.hello = peer.meet();
  peer.welcome(run.hello.participant, timeout_s);
  run.description = ask<wire::Description>(peer, wire::Describe{});
  check_description(run.hello, run.description);
}

ContractAnswer synchronise(ContractPeer& peer, const ContractRun& run, const std::vector<double>& input,
                           Integration integration) {
  wire::Synchronise request;
  request.integration = name_of(integration);
  request.link_absolute = run.description.interface_position_m;
  request.link_absolute.data = input;
  const auto& answer = ask<wire::Synchronised>(peer, request);
  return {output_of(answer.absolute, "absolute", run), answer.velocity_m_s.data, answer.acceleration_m_s2.data};
}

ContractAnswer try_window(ContractPeer& peer, const ContractRun& run, int window, const std::vector<double>& last,
                          const std::vector<double>& input, bool accept) {
  const auto& answer = advance_by(peer, run, window, last, input, accept);
  return {output_of(answer.increment, "increment", run), answer.velocity_m_s.data, answer.acceleration_m_s2.data};
}

void start(ContractPeer& peer, const ContractDrive& drive, ContractRun& run) {
  const double critical = run.description.critical_time_step_s;
  run.window_size_s = drive.window_size_s > 0 ? drive.window_size_s : critical > 0 ? 0.5 * critical : 1e-6;
  run.by_force = drive.by_force || run.implicit();
  run.first_output = output_of(ask<wire::Initialized>(peer, initialize_request(run, drive)).absolute, "absolute", run);
  wire::Synchronise request;
  const bool newmark = run.implicit() && !drive.as_explicit;
  request.integration = name_of(newmark ? Integration::implicit_newmark : Integration::explicit_central);
  run.input = input_at(run, drive, 0, false);
  request.link_absolute = run.description.interface_position_m;
  request.link_absolute.data = run.input;
  const auto& answer = ask<wire::Synchronised>(peer, request);
  run.output = output_of(answer.absolute, "absolute", run);
  take_rates(answer, wire::Synchronised::kind, run);
  if (drive.begin_with_s > 0) ask<wire::Reconfigured>(peer, wire::Reconfigure{run.window_size_s, {}});
}

void advance(ContractPeer& peer, const ContractDrive& drive, ContractRun& run) {
  start(peer, drive, run);
  for (int window = 1; window <= drive.windows; ++window) one_window(peer, drive, window, run);
}

namespace {

/// The first process as far as `drive.save_at`; what it saved there.
wire::RestoreState first_half(const ContractCommand& command, const ContractDrive& drive, ContractRun& run) {
  ContractPeer peer(command);
  describe(peer, command.timeout_s, run);
  start(peer, drive, run);
  for (int window = 1; window <= drive.save_at; ++window) one_window(peer, drive, window, run);
  return {ask<wire::SavedState>(peer, wire::SaveState{}, drive.save_at).saved};
}

/// A process that is where the first one was.
void take_over(ContractPeer& peer, const ContractCommand& command, const ContractDrive& drive,
               const wire::RestoreState& saved) {
  ContractRun another;
  describe(peer, command.timeout_s, another);
  start(peer, drive, another);
  ask<wire::StateRestored>(peer, saved);
}

}  // namespace

void run_contract(const ContractCommand& command, const ContractDrive& drive, ContractRun& run) {
  wire::RestoreState saved;
  if (drive.save_at > 0) saved = first_half(command, drive, run);
  ContractPeer peer(command);
  if (drive.save_at > 0) {
    take_over(peer, command, drive, saved);
    for (int window = drive.save_at + 1; window <= drive.windows; ++window) one_window(peer, drive, window, run);
  } else {
    describe(peer, command.timeout_s, run);
    advance(peer, drive, run);
  }
  append(ask<wire::Finished>(peer, wire::Finish{}, drive.windows).records.data, run.records);
  const auto end = peer.wait_end();
  if (!end) throw ParticipantError(fmt::format("after 'finish' it still ran {} s later", command.timeout_s));
  if (end->signal != 0 || end->exit_status != 0) {
    throw ParticipantError(fmt::format("after 'finish' it {}{}", end->text(), peer.log_tail()));
  }
}

}  // namespace ricochet::coupler
