// Clauses about what a participant goes on from.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/base/error.hpp"
#include "coupler/contract/contract_response.hpp"

namespace ricochet::coupler {
namespace {

/// Random numbers that are the same everywhere.
Values some_numbers(std::size_t count, std::uint32_t seed) {
  Values result;
  for (std::size_t i = 0; i < count; ++i) {
    seed = seed * 1664525U + 1013904223U;
    result.push_back(seed / 4294967296.0 - 0.5);
  }
  return result;
}

Values sum_of(Values a, const Values& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

}  // namespace

void require_capability(const ContractRun& first, Capability capability, const std::string& who_needs_it) {
  if (first.description.has(capability)) return;
  throw NotApplicable{fmt::format("it does not announce \"{}\" ({})", name_of(capability), who_needs_it)};
}

void require_role(const ContractRun& first, Role role) {
  if (first.implicit() != (role == Role::implicit_solver))
    throw NotApplicable{fmt::format("it is not {}", name_of(role))};
}

std::string place(const ContractRun& run, std::size_t row) {
  const auto components = static_cast<std::size_t>(run.description.components);
  return components == 1 ? fmt::format("interface node {}", row)
                         : fmt::format("interface node {}, component {}", row / components, row % components);
}

double probe_size(const ContractRun& run, std::size_t row) {
  const auto node = row / static_cast<std::size_t>(run.description.components);
  const double displacement = std::max(largest(run.description.interface_position_m.data), 1.0) * 1e-6;
  if (!run.by_force) return displacement;
  return run.description.interface_mass_kg.data[node] * displacement / (run.window_size_s * run.window_size_s);
}

std::string switch_integration(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first) {
  require_role(first, Role::implicit_solver);
  require_capability(first, Capability::switch_integration, "it stays implicit after separation");
  ContractDrive central = drive;
  central.as_explicit = true;
  ContractRun run;
  run_contract(command, central, run);
  const double dt = run.window_size_s, scale = largest(run.output);
  for (std::size_t k = run.size(); k < run.output.size(); ++k) {
    const std::size_t last = k - run.size();
    const double expected = run.output[last] + dt * run.velocity[last] + 0.5 * dt * dt * run.acceleration[last];
    if (std::abs(run.output[k] - expected) <= rounding * scale) continue;
    fail(fmt::format("window {}, {}: displacement is {:.6g} m, by central differences it is {:.6g} m", k / run.size(),
                     place(run, k % run.size()), run.output[k], expected));
  }
  return "";
}

std::string load_their_motion(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first) {
  require_capability(first, Capability::load_state, "`ricochet stability` will refuse it");
  ContractPeer peer(command);
  ContractRun run;
  describe(peer, command.timeout_s, run);
  start(peer, drive, run);
  const auto integration = run.implicit() ? Integration::implicit_newmark : Integration::explicit_central;
  const auto tell = [&]() -> wire::State {
    wire::Message request;
    request.make<wire::ReadState>();
    return peer.ask(request).as<wire::State>();
  };
  const auto load = [&](const Values& state, const Values& input) {
    wire::Message request;
    auto& message = request.make<wire::LoadState>();
    message.frozen_contact = name_of(FrozenContact::open);
    message.state.resize(static_cast<int>(state.size()), 1);
    message.state.data = state;
    peer.ask(request);
    synchronise(peer, run, input, integration);
  };
  const Values scale = tell().state_scale.data;
  const auto scaled = [&scale](Values state) {
    for (std::size_t i = 0; i < state.size(); ++i) state[i] *= scale[i];
    return state;
  };
  const auto state_of = [&scale](const Values& numbers) {
    Values state = numbers;
    for (std::size_t i = 0; i < state.size(); ++i) state[i] /= scale[i];
    return state;
  };
  int window = 0;
  const auto after_window = [&](const Values& numbers, const Values& last, const Values& input) {
    load(state_of(numbers), last);
    const Values told = scaled(tell().state.data);
    for (std::size_t i = 0; i < told.size(); ++i) {
      if (std::abs(told[i] - numbers[i]) <= rounding) continue;
      fail(fmt::format("number {} of {} of its state: loaded {:.6g}, read back {:.6g}", i, told.size(),
                       numbers[i] / scale[i], told[i] / scale[i]));
    }
    try_window(peer, run, ++window, last, input, true);
    return scaled(tell().state.data);
  };
  const auto inputs = [&](std::uint32_t seed) {
    Values values = some_numbers(run.size(), seed);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] *= probe_size(run, i);
    return values;
  };
  const Values a = some_numbers(scale.size(), 1), b = some_numbers(scale.size(), 2);
  const Values a0 = inputs(3), b0 = inputs(4), a1 = inputs(5), b1 = inputs(6);
  const Values of_a = after_window(a, a0, a1), of_b = after_window(b, b0, b1);
  const Values of_both = after_window(sum_of(a, b), sum_of(a0, b0), sum_of(a1, b1)), sum = sum_of(of_a, of_b);
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (std::abs(of_both[i] - sum[i]) <= rounding * largest(sum)) continue;
    fail(
        fmt::format("number {} of {} of its state after a window is not linear in what was loaded: {:.6g} after the "
                    "sum of two states, the sum after each is {:.6g} (loads, supports and contact must be homogeneous)",
                    i, sum.size(), of_both[i] / scale[i], sum[i] / scale[i]));
  }
  return "";
}

}  // namespace ricochet::coupler
