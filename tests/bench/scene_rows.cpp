#include "tests/bench/scene_rows.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "common/check/check.hpp"
#include "tests/bench/exchange.hpp"
#include "tests/bench/in_child.hpp"
#include "tests/bench/reference_scene.hpp"
#include "tests/support/one_process.hpp"

namespace ricochet::bench {
namespace {

const std::string one_process = "one process", two_explicit = "two explicit", whole_run = "whole run, one thread";
constexpr int whole_scene_steps = 763;  // of the 0.5 mm mesh, until 10 us after separation

std::string with_history(const std::string& protocol) { return protocol + ", history of every window"; }

/// Measured once, on another machine: the engine of OpenRadioss on the reference scene (axisymmetric quadrilaterals,
/// friction, one thread, without its start), and there K u of the same mesh by the kernel element_by_element.
struct OpenRadioss {
  double engine_s, element_by_element_s;
};
const std::map<int, OpenRadioss> openradioss = {{1, {0.40, 20.7e-6}}, {2, {2.5, 92.6e-6}}, {4, {27.7, 838e-6}}};

/// Protocols that are timed on the coarsest mesh only, for the table of protocols.
const std::vector<std::string> others = {"kim", "kim_predicted", "belytschko_mullen", "gravouil_combescure",
                                         "fixed_point"};

/// Lengths of the carbide cylinder that show what rows without a wave cost; the long one on the coarsest mesh only.
std::vector<int> carbide_lengths(bool coarsest) { return coarsest ? std::vector<int>{1, 8} : std::vector<int>{1}; }

std::string dual(int substeps) { return fmt::format("prakash_hjelmstad, m = {}", substeps); }

std::map<std::string, SceneChoice> methods(int refinement, bool coarsest, long steps) {
  SceneChoice base;
  base.refinement = refinement;
  base.steps = steps;
  std::map<std::string, SceneChoice> result;
  for (const char* protocol : {"hughes_liu", "all_implicit", "all_explicit"}) {
    result[protocol] = base;
    result[protocol].protocol = protocol;
  }
  for (const auto& protocol : coarsest ? others : std::vector<std::string>{}) {
    result[protocol] = base;
    result[protocol].protocol = protocol;
  }
  for (const int m : {1, 2, 4}) {
    result[dual(m)] = base;
    result[dual(m)].protocol = "prakash_hjelmstad";
    result[dual(m)].substeps = m;
  }
  result[one_process] = result[two_explicit] = base;
  for (const char* protocol : {"hughes_liu", "all_explicit"}) {
    result[with_history(protocol)] = result[protocol];
    result[with_history(protocol)].every_step = true;
  }
  result[whole_run] = result["all_explicit"];
  result[whole_run].steps = refinement * whole_scene_steps;
  result[whole_run].participants =
      "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\nthreads = 1\n";
  result[two_explicit].participants = two_explicit_participants();
  return result;
}

double count_unknowns(const std::string& scene_path) {
  double unknowns = 0.0;
  for (const auto& participant : scene::plan_participants(scene::build_problem(scene::load_scene(scene_path)))) {
    unknowns += participant.unknowns;
  }
  return unknowns;
}

template <class Value>
std::vector<double> each(const std::vector<SceneRun>& runs, Value value) {
  std::vector<double> values;
  for (const auto& run : runs) values.push_back(value(run));
  return values;
}

std::vector<double> steps_s(const std::vector<SceneRun>& runs) {
  return each(runs, [](const SceneRun& run) { return run.step_s; });
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

}  // namespace

SceneRuns::SceneRuns(const std::string& folder, const std::vector<int>& refinements, long steps)
    : folder_(folder), refinements_(refinements), steps_(steps) {
  for (const int n : refinements) {
    SceneChoice whole;
    whole.refinement = n;
    whole.protocol = "all_implicit";
    const std::string scene = write_reference_scene(whole, folder + "/whole.toml");
    unknowns_[n] = in_child([&scene] { return count_unknowns(scene); });
  }
}

void SceneRuns::repeat() {
  for (const int n : refinements_) {
    for (const auto& [method, choice] : methods(n, n == refinements_.front(), steps_)) {
      const std::string scene = write_reference_scene(choice, folder_ + "/scene.toml");
      auto& runs = runs_[n][method];
      if (method == one_process) {
        SceneRun run;
        run.window_s = run.step_s = in_child([&scene] { return test::run_in_one_process(scene); });
        runs.push_back(run);
      } else {
        runs.push_back(run_scene(scene, choice.substeps, folder_ + "/run"));
      }
    }
    for (const int lengths : carbide_lengths(n == refinements_.front())) {
      SceneChoice choice;
      choice.refinement = n;
      choice.steps = steps_;
      choice.protocol = "all_explicit";
      choice.carbide_lengths = lengths;
      const std::string scene = write_reference_scene(choice, folder_ + "/scene.toml");
      for (const bool all_rows : {false, true}) {
        unreached_s_[{n, lengths, all_rows}].push_back(
            in_child([&] { return test::run_in_one_process(scene, all_rows); }));
      }
    }
  }
}

void SceneRuns::add_unreached(int n, std::vector<Row>& rows) const {
  for (const int lengths : carbide_lengths(n == refinements_.front())) {
    rows.push_back(
        {fmt::format("all_explicit: rows that waves have reached / all rows, carbide of {} mm", 80 * lengths),
         mesh_name(n),
         quotients(unreached_s_.at({n, lengths, false}), unreached_s_.at({n, lengths, true})),
         {}});
  }
}

const SceneRuns::Runs& SceneRuns::at(int refinement, const std::string& method) const {
  return runs_.at(refinement).at(method);
}

void SceneRuns::add_costs(int n, std::vector<Row>& rows) const {
  static const std::map<int, double> against_implicit = {{1, 0.45}, {2, 0.22}, {4, 0.18}};
  const std::string mesh = mesh_name(n);
  const auto hybrid = steps_s(at(n, "hughes_liu"));
  std::optional<Level> level;
  if (against_implicit.count(n)) level = Level{true, against_implicit.at(n)};
  rows.push_back({"hughes_liu / all_implicit", mesh, quotients(hybrid, steps_s(at(n, "all_implicit"))), level});
  rows.push_back({"hughes_liu / all_explicit", mesh, quotients(hybrid, steps_s(at(n, "all_explicit"))), {}});
  const auto cpu = [](const SceneRun& run) { return run.usage.cpu_s; };
  rows.push_back({"hughes_liu / all_implicit, processor time of the whole command",
                  mesh,
                  quotients(each(at(n, "hughes_liu"), cpu), each(at(n, "all_implicit"), cpu)),
                  {}});
  level = n == 2 ? std::optional(Level{true, 1.10}) : std::nullopt;
  rows.push_back({"hughes_liu, three processes / one", mesh, quotients(hybrid, steps_s(at(n, one_process))), level});
  rows.push_back(
      {"hughes_liu, two explicit participants / one", mesh, quotients(steps_s(at(n, two_explicit)), hybrid), {}});
}

void SceneRuns::add_others(int n, std::vector<Row>& rows) const {
  for (const auto& protocol : others) {
    rows.push_back({protocol + " / all_implicit",
                    mesh_name(n),
                    quotients(steps_s(at(n, protocol)), steps_s(at(n, "all_implicit"))),
                    {}});
  }
}

void SceneRuns::add_dual(int n, std::vector<Row>& rows) const {
  const auto speed = [](const SceneRun& run) { return run.speed_change_m_s; };
  const auto reference = each(at(n, "all_implicit"), speed);
  const auto add_error = [&](const std::string& method) {
    auto errors = quotients(each(at(n, method), speed), reference);
    for (double& error : errors) error = std::abs(error - 1.0);
    rows.push_back({method + ": error of the impulse against all_implicit", mesh_name(n), errors, {}});
  };
  add_error("hughes_liu");
  for (const int m : {1, 2, 4}) {
    for (const char* other : {"all_implicit", "all_explicit"}) {
      rows.push_back({fmt::format("{} / {}", dual(m), other),
                      mesh_name(n),
                      quotients(steps_s(at(n, dual(m))), steps_s(at(n, other))),
                      {}});
    }
    add_error(dual(m));
  }
}

void SceneRuns::add_bounds(int n, const Kernels& kernels, std::vector<Row>& rows) const {
  rows.push_back({"all_explicit run: element-steps per second / bound",
                  mesh_name(n),
                  quotients(kernels.bound_s("stiffness_product", n), steps_s(at(n, "all_explicit"))),
                  {}});
  rows.push_back({"all_implicit run: solves per second / bound",
                  mesh_name(n),
                  quotients(kernels.bound_s("condensed_solve", n), steps_s(at(n, "all_implicit"))),
                  {}});
}

void SceneRuns::add_openradioss(int n, const Kernels& kernels, std::vector<Row>& rows) const {
  const auto there = openradioss.find(n);
  if (there == openradioss.end()) return;
  const auto as_fast_as_here =
      scaled(kernels.times_s("element_by_element", n), there->second.engine_s / there->second.element_by_element_s);
  rows.push_back({"OpenRadioss' engine / all_explicit, whole run, one thread each", mesh_name(n),
                  quotients(as_fast_as_here, each(at(n, whole_run), [](const SceneRun& run) { return run.wall_s; })),
                  Level{false, 15.0}});
}

void SceneRuns::add_history(int n, std::vector<Row>& rows) const {
  for (const char* method : {"hughes_liu", "all_explicit"}) {
    rows.push_back({fmt::format("{}: history of every window / none", method), mesh_name(n),
                    quotients(steps_s(at(n, with_history(method))), steps_s(at(n, method))), Level{true, 1.15}});
  }
}

void SceneRuns::add_setup(int n, std::vector<Row>& rows) const {
  for (const char* method : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const auto& runs = at(n, method);
    const bool wanted = n == 2 && std::string(method) == "hughes_liu";
    rows.push_back({fmt::format("{}: set-up / stepping through the whole scene", method), mesh_name(n),
                    quotients(each(runs, [](const SceneRun& run) { return run.setup_s; }),
                              scaled(steps_s(runs), n * whole_scene_steps)),
                    wanted ? std::optional(Level{true, 0.25}) : std::nullopt});
  }
}

/// Growth from the coarsest mesh, over that of the unknowns: 1 is linear.
void SceneRuns::add_growth(int n, std::vector<Row>& rows) const {
  const int coarsest = refinements_.front();
  const double growth = unknowns_.at(n) / unknowns_.at(coarsest);
  const auto size = [](const SceneRun& run) { return run.usage.largest_process_b; };
  for (const char* method : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const auto &fine = at(n, method), &coarse = at(coarsest, method);
    const auto add = [&](const char* what, const std::vector<double>& ratios) {
      rows.push_back({fmt::format("{}: growth of {} from {} / of unknowns", method, what, mesh_name(coarsest)),
                      mesh_name(n),
                      scaled(ratios, 1.0 / growth),
                      {}});
    };
    add("time per step", quotients(steps_s(fine), steps_s(coarse)));
    add("memory of the largest process", quotients(each(fine, size), each(coarse, size)));
  }
}

std::vector<Row> SceneRuns::rows(const Kernels* kernels) const {
  std::vector<Row> rows;
  for (const int n : refinements_) {
    add_costs(n, rows);
    add_unreached(n, rows);
    if (n == refinements_.front()) add_others(n, rows);
    add_dual(n, rows);
    add_setup(n, rows);
    add_history(n, rows);
    if (kernels) add_bounds(n, *kernels, rows);
    if (kernels) add_openradioss(n, *kernels, rows);
    if (n != refinements_.front()) add_growth(n, rows);
  }
  return rows;
}

void Exchanges::repeat() {
  for (const auto& [nodes, windows] : {std::pair{11, 4000}, {101, 4000}, {1001, 1500}, {10001, 200}}) {
    plain_s_[nodes].push_back(ping_pong_s(nodes, windows));
    for (const char* transport : {"auto", "zmq"}) {
      SceneChoice choice;
      choice.steps = windows;
      choice.transport = transport;
      choice.participants = echo_participants(nodes);
      const auto run = run_scene(write_reference_scene(choice, folder_ + "/echo.toml"), 1, folder_ + "/run");
      (choice.transport == "auto" ? shared_memory_s_ : zeromq_s_)[nodes].push_back(run.window_s);
    }
  }
}

std::vector<Row> Exchanges::rows() const {
  std::vector<Row> rows;
  for (const auto& [nodes, plain] : plain_s_) {
    const std::string at = fmt::format("{} nodes", nodes);
    const auto level = nodes == 101 ? std::optional(Level{true, 0.15}) : std::nullopt;
    rows.push_back({"exchange, shared memory / ping-pong of the same bytes", at,
                    quotients(shared_memory_s_.at(nodes), plain), level});
    rows.push_back({"exchange, ZeroMQ / ping-pong of the same bytes", at, quotients(zeromq_s_.at(nodes), plain), {}});
  }
  return rows;
}

}  // namespace ricochet::bench
