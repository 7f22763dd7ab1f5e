// The functions of ricochet.h: OwnLoop without exceptions, classes and vectors.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/participant/own_loop.hpp"
#pragma GCC visibility push(default)  // the one thing that the shared library shows
#include "common/participant/c/ricochet.h"
#pragma GCC visibility pop

using namespace ricochet;

struct ricochet_loop {
  participant::Arguments arguments;
  participant::Description description;
  std::optional<participant::OwnLoop> loop;  ///< from ricochet_initialize on

  [[nodiscard]] std::size_t numbers() const {
    return description.interface_body.size() * static_cast<std::size_t>(description.components);
  }
};

namespace {

template <class Act>
int guarded(const ricochet_loop* loop, const Act& act) noexcept {
  try {
    act();
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: error: {}\n", loop ? loop->arguments.name : "participant", text_of(error));
    return exit_code_of_exception(error);
  }
}

/// The reason why the conversation fails stands on standard error already.
template <class Act>
int guarded_exchange(const Act& act) noexcept {
  try {
    act();
    return 0;
  } catch (const std::exception& error) {
    return exit_code_of_exception(error);
  }
}

void require_loop(const ricochet_loop* loop, const char* function) {
  if (!loop) throw ConfigError(fmt::format("{} was called without a loop: ricochet_open gave none", function));
}

participant::Description& description_of(ricochet_loop* loop, const char* function) {
  require_loop(loop, function);
  if (loop->loop) throw ConfigError(fmt::format("{} must come before ricochet_initialize", function));
  return loop->description;
}

template <class Loop>
auto& running(Loop* loop, const char* function) {
  require_loop(loop, function);
  if (!loop->loop) throw ConfigError(fmt::format("{} must come after ricochet_initialize", function));
  return *loop->loop;
}

/// Answer of the loop about the window to compute. `otherwise`: there is none, or the run has failed, which
/// ricochet_close tells.
template <class T, class Ask>
T asked(const ricochet_loop* loop, T otherwise, const Ask& ask) noexcept {
  if (!loop || !loop->loop) return otherwise;
  try {
    return ask(*loop->loop);
  } catch (const std::exception&) {
    return otherwise;
  }
}

/// The value of that name, of those that are allowed.
template <class E>
E named(const char* what, const char* name, const std::vector<std::string>& allowed) {
  const std::string text = name ? name : "";
  const bool known = std::find(allowed.begin(), allowed.end(), text) != allowed.end();
  if (known) return *find_named<E>(text);
  throw ConfigError(
      fmt::format("{} \"{}\", allowed are {}{}", what, text, fmt::join(allowed, ", "), did_you_mean(text, allowed)));
}

std::vector<double> copied(const double* values, std::size_t count) {
  return values ? std::vector<double>(values, values + count) : std::vector<double>{};
}

/// The arguments of this process: a caller in Fortran has no argv.
participant::Arguments own_arguments() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  std::vector<const char*> argv;
  for (const auto& word : words) argv.push_back(word.c_str());
  return participant::parse_arguments(static_cast<int>(argv.size()), argv.data());
}

}  // namespace

ricochet_loop* ricochet_open(const char* role, const char* solver, int components) {
  auto opened = std::make_unique<ricochet_loop>();
  const int error = guarded(nullptr, [&] {
    opened->arguments = own_arguments();
    auto& d = opened->description;
    d.name = opened->arguments.name;
    d.role = named<Role>("unknown role", role, all_names<Role>());
    d.solver = solver ? solver : "";
    d.components = components;
  });
  return error == 0 ? opened.release() : nullptr;
}

const char* ricochet_scene(const ricochet_loop* loop) { return loop ? loop->arguments.scene.c_str() : ""; }
const char* ricochet_name(const ricochet_loop* loop) { return loop ? loop->arguments.name.c_str() : ""; }

int ricochet_add_body(ricochet_loop* loop, const char* body) {
  return guarded(loop, [&] { description_of(loop, "ricochet_add_body").bodies.emplace_back(body); });
}

int ricochet_set_interface(ricochet_loop* loop, int nodes, const int* body, const double* position,
                           const double* mass) {
  return guarded(loop, [&] {
    auto& d = description_of(loop, "ricochet_set_interface");
    if (nodes < 0) throw ConfigError(fmt::format("ricochet_set_interface: found {} nodes, allowed are >= 0", nodes));
    d.interface_body.assign(body, body + nodes);
    d.interface_position_m = copied(position, loop->numbers());
    d.interface_mass_kg = copied(mass, static_cast<std::size_t>(nodes));
  });
}

int ricochet_set_critical_time_step(ricochet_loop* loop, double step_s) {
  return guarded(loop, [&] { description_of(loop, "ricochet_set_critical_time_step").critical_time_step_s = step_s; });
}

int ricochet_add_capability(ricochet_loop* loop, const char* capability) {
  return guarded(loop, [&] {
    const std::vector<std::string> allowed{"repeat_window", "driven_by_force",
                                           "reconfigure"};  // what the time loop can do
    description_of(loop, "ricochet_add_capability")
        .capabilities.push_back(named<Capability>("ricochet_add_capability: found", capability, allowed));
  });
}

int ricochet_add_column(ricochet_loop* loop, const char* column) {
  return guarded(loop, [&] { description_of(loop, "ricochet_add_column").record_columns.emplace_back(column); });
}

int ricochet_initialize(ricochet_loop* loop, const double* value, const double* record) {
  const int error = guarded(loop, [&] {
    const auto& description = description_of(loop, "ricochet_initialize");
    loop->loop.emplace(description, loop->arguments.options);
  });
  if (error != 0) return error;
  return guarded_exchange([&] {
    loop->loop->initialize({copied(value, loop->numbers()), {}, {}},
                           copied(record, loop->description.record_columns.size()));
  });
}

double ricochet_window_size(const ricochet_loop* loop) {
  return loop && loop->loop ? loop->loop->setup().clock.size_s() : 0.0;
}
int ricochet_substeps(const ricochet_loop* loop) { return loop && loop->loop ? loop->loop->setup().substeps : 0; }
int ricochet_driven_by_force(const ricochet_loop* loop) {
  return loop && loop->loop && loop->loop->setup().driven_by == Drive::force ? 1 : 0;
}

int ricochet_interface_mass(const ricochet_loop* loop, double* mass) {
  return guarded(loop, [&] {
    const auto& masses = running(loop, "ricochet_interface_mass").setup().interface_mass_kg;
    std::copy(masses.begin(), masses.end(), mass);
  });
}

int ricochet_directions(const ricochet_loop* loop, double* directions) {
  return guarded(loop, [&] {
    const auto& given = running(loop, "ricochet_directions").setup().directions;
    std::copy(given.begin(), given.end(), directions);
  });
}

int ricochet_scene_position(const ricochet_loop* loop, double* position) {
  return guarded(loop, [&] {
    const auto& given = running(loop, "ricochet_scene_position").setup().scene_position_m;
    std::copy(given.begin(), given.end(), position);
  });
}

int ricochet_progress(ricochet_loop* loop, const char* doing, double share_done) {
  return guarded(loop, [&] { running(loop, "ricochet_progress").progress(doing ? doing : "", share_done); });
}

int ricochet_ongoing(const ricochet_loop* loop) {
  return asked(loop, 0, [](const auto& running) { return running.ongoing() ? 1 : 0; });
}
double ricochet_max_time_step(const ricochet_loop* loop) {
  return asked(loop, 0.0, [](const auto& running) { return running.max_time_step(); });
}
int ricochet_must_save(const ricochet_loop* loop) {
  return asked(loop, 0, [](const auto& running) { return running.must_save() ? 1 : 0; });
}
int ricochet_must_restore(const ricochet_loop* loop) {
  return asked(loop, 0, [](const auto& running) { return running.must_restore() ? 1 : 0; });
}

int ricochet_read(const ricochet_loop* loop, double* link) {
  return guarded(loop, [&] {
    const auto& input = running(loop, "ricochet_read").read();
    std::copy(input.begin(), input.end(), link);
  });
}

int ricochet_write(ricochet_loop* loop, const double* value, const double* velocity, const double* acceleration,
                   const double* record) {
  return guarded(loop, [&] {
    auto& running_loop = running(loop, "ricochet_write");
    const auto size = loop->numbers();
    running_loop.write({copied(value, size), copied(velocity, size), copied(acceleration, size)},
                       copied(record, loop->description.record_columns.size()));
  });
}

int ricochet_advance(ricochet_loop* loop) {
  if (!loop || !loop->loop) return guarded(loop, [&] { static_cast<void>(running(loop, "ricochet_advance")); });
  return guarded_exchange([&] { loop->loop->advance(); });
}

int ricochet_close(ricochet_loop* loop) {
  const int error = guarded(loop, [&] { require_loop(loop, "ricochet_close"); });
  if (error != 0) return error;
  const int of_run = loop->loop ? loop->loop->finalize() : 0;
  delete loop;
  return of_run;
}
