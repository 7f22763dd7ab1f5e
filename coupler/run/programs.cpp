#include "coupler/run/programs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/read_file.hpp"

namespace ricochet::coupler {
namespace {

using Fact = Program::Fact;

constexpr double same = 1e-7;
/// Displacement that is tried, or that a force is sized to cause in a window, in extents of the scene [m/m].
constexpr double probe_share = 1e-6;

Fact fact_of(const wire::Field& field, const wire::Message& message) {
  Fact fact{fmt::format("'{}'", field.name), ""};
  std::visit(
      [&](const auto* value) {
        using Value = std::decay_t<decltype(*value)>;
        if constexpr (std::is_same_v<Value, wire::Array>) {
          fact.text = fmt::format("{} x {} numbers", value->rows, value->columns);
          fact.numbers = value->data;
        } else if constexpr (std::is_same_v<Value, double>) {
          fact.numbers = {*value};
        } else if constexpr (std::is_same_v<Value, std::vector<std::string>>) {
          fact.text = fmt::format("{}", fmt::join(*value, ", "));
        } else if constexpr (std::is_same_v<Value, std::string> || std::is_same_v<Value, bool> ||
                             std::is_same_v<Value, std::int64_t>) {
          fact.text = fmt::format("{}", *value);
        }
      },
      field.of(message));
  return fact;
}

std::vector<Fact> described(const wire::Description& description) {
  wire::Message message;
  message.make<wire::Description>() = description;
  std::vector<Fact> facts;
  for (const auto& field : wire::fields_of(wire::Kind::description)) facts.push_back(fact_of(field, message));
  return facts;
}

/// Largest extent of a body [m]; of a scene without meshes, of what is joined, none is known.
double extent(const scene::Problem& problem) {
  double largest = 0.0;
  for (const auto& body : problem.bodies) {
    for (const auto& x : body.mesh.position) largest = std::max(largest, (x - body.mesh.position.front()).norm());
  }
  return largest > 0.0 ? largest : 1.0;
}

/// No two neighbouring rows alike, [0.5, 1.5).
double weight(std::size_t row) { return 0.5 + std::fmod(0.618 * static_cast<double>(row), 1.0); }

/// Its answer to another link input: its force to a displacement; its velocity after a window with a force, where
/// it can repeat one, else its acceleration by it. It is left as it was.
Fact answer_to_a_trial(Link& link, double extent_m, double window_s) {
  const auto input = link.input();
  if (input.empty()) return {};
  const auto integration = link.implicit() ? Integration::implicit_newmark : Integration::explicit_central;
  const auto synchronise = [&](const std::vector<double>& values) {
    link.post_synchronise(integration, values);
    link.wait_synchronised();
  };
  const auto mass_kg = link.own_mass_kg();
  std::vector<double> tried = input;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const double shift_m = probe_share * extent_m * weight(i);
    tried[i] += link.driven_by_force() ? mass_kg[i] * shift_m / (window_s * window_s) : shift_m;
  }
  Fact fact{"its answer to a change of its link input that was tried at the start", ""};
  if (link.driven_by_force() && link.description().has(Capability::repeat_window)) {
    link.post_advance({}, tried, Acceptance::trial);
    link.wait_advanced();
    fact.numbers = link.velocity_m_s();
  } else {
    synchronise(tried);
    fact.numbers = link.driven_by_force() ? link.acceleration_m_s2() : link.output();
  }
  synchronise(input);
  return fact;
}

[[noreturn]] void refuse(const Program& now, const std::string& what, const std::string& before,
                         const std::string& found) {
  throw ConfigError(
      fmt::format("participant '{}': its program is another one than this run began with: {} was {}, it is {}; go on "
                  "with the program that began, or begin again with `{} run`",
                  now.participant, what, before, found, command_name));
}

void require_same_numbers(const Program& program, const Fact& before, const Fact& now) {
  const auto count = [](const Fact& fact) { return fmt::format("{} numbers", fact.numbers.size()); };
  if (before.numbers.size() != now.numbers.size()) refuse(program, now.what, count(before), count(now));
  double largest = 0.0;
  for (const double value : before.numbers) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < now.numbers.size(); ++i) {
    const double then = before.numbers[i], found = now.numbers[i];
    if (std::abs(found - then) <= same * largest) continue;
    const auto place = now.numbers.size() == 1 ? "" : fmt::format(", number {}", i);
    refuse(program, now.what + place, fmt::format("{:.9g}", then), fmt::format("{:.9g}", found));
  }
}

}  // namespace

std::vector<Program> programs_of(const scene::Problem& problem, const std::vector<PeerDescription>& descriptions,
                                 const std::vector<std::string>& executables, std::vector<Link>& links) {
  std::vector<Program> programs;
  for (std::size_t p = 0; p < descriptions.size(); ++p) {
    Program program{descriptions[p].participant, described(descriptions[p])};
    if (problem.scene.participants[p].foreign()) {
      if (!executables[p].empty())
        program.facts.push_back({fmt::format("the SHA-256 of {}", executables[p]), digest_of_file(executables[p])});
      program.facts.push_back(answer_to_a_trial(links[p], extent(problem), problem.clock.size_s(1)));
    }
    programs.push_back(std::move(program));
  }
  return programs;
}

void require_same(const std::vector<Program>& began, const std::vector<Program>& now) {
  for (std::size_t p = 0; p < now.size(); ++p) {
    const auto& program = now[p];
    const bool known = p < began.size() && began[p].participant == program.participant &&
                       began[p].facts.size() == program.facts.size();
    if (!known) throw ConfigError(fmt::format("the checkpoint knows no such program of '{}'", program.participant));
    for (std::size_t f = 0; f < program.facts.size(); ++f) {
      const auto &before = began[p].facts[f], &fact = program.facts[f];
      if (before.what != fact.what) refuse(program, "what is known of it", before.what, fact.what);
      if (before.text != fact.text) refuse(program, fact.what, before.text, fact.text);
      require_same_numbers(program, before, fact);
    }
  }
}

}  // namespace ricochet::coupler
