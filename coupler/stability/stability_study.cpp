#include "coupler/stability/stability_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"
#include "common/check/check.hpp"
#include "common/scene/variant.hpp"
#include "coupler/processes/machine_check.hpp"
#include "coupler/protocols/protocol.hpp"
#include "coupler/report/stability_page/stability_page.hpp"
#include "coupler/stability/stability_axis.hpp"
#include "coupler/stability/stability_point.hpp"

namespace ricochet::coupler {
namespace {

/// Two steps this close, stable and unstable, are a measured edge.
constexpr double edge_ratio = 1.005;

struct Point {
  std::size_t column = 0;  ///< which value of the other parameter
  double step_s = 0.0, predicted_edge_s = 0.0;
  FrozenContact contact = FrozenContact::open;
  SpectralRadius radius;
};

struct Edge {
  std::size_t column = 0;
  FrozenContact contact = FrozenContact::open;
  double predicted_s = 0.0, stable_s = 0.0, unstable_s = 0.0;  ///< 0: not within the sweep
};

std::string step_text(double step_s) { return std::isfinite(step_s) ? fmt::format("{:.6g}", step_s) : "none"; }

/// The predicted edge of the window: as many steps as it has, each as long as what is explicit stands [s].
double critical_window_s(const scene::Problem& problem, const std::vector<scene::ParticipantPlan>& plans) {
  double window_s = std::numeric_limits<double>::infinity();
  for (const auto& plan : plans)
    window_s = std::min(window_s, problem.scene.participant(plan.name).substeps * plan.critical_time_step_s);
  return window_s;
}

/// One sweep: which variants of the scene there are, and what came of them.
class StabilityStudy {
 public:
  StabilityStudy(const StabilityRequest& request, const scene::Problem& problem, const ResultsDirectory& results)
      : problem_(problem),
        results_(results),
        steps_(parse_step_axis("--sweep", request.sweep)),
        against_{"coupling.protocol", {problem.scene.coupling.protocol.name}, false},
        bisects_(request.edge) {
    if (!request.against.empty()) against_ = parse_axis("--against", request.against);
    std::filesystem::create_directories(results.file("variants"));
  }

  void run();
  void write_files() const;

 private:
  [[nodiscard]] scene::Problem variant(std::size_t column, std::optional<double> step_s);
  void measure(std::size_t column, const scene::Problem& problem, const std::vector<FrozenContact>& contacts);
  void run_column(std::size_t column);
  void bisect(std::size_t column, FrozenContact contact);
  void print_participants() const;
  void print(const Point& point) const;
  void print(const Edge& edge) const;
  [[nodiscard]] std::vector<FrozenContact> contacts() const;
  [[nodiscard]] std::size_t label_width() const { return std::max<std::size_t>(20, against_.key.size()); }
  [[nodiscard]] bool by_courant() const { return steps_.key == "courant"; }
  [[nodiscard]] std::vector<std::string> notes() const;
  [[nodiscard]] report::StabilityMap map() const;
  [[nodiscard]] std::string csv() const;

  const scene::Problem& problem_;
  const ResultsDirectory& results_;
  Axis steps_, against_;
  bool bisects_;
  int variants_ = 0;
  std::vector<Point> points_;
  std::vector<Edge> edges_;
};

std::vector<FrozenContact> StabilityStudy::contacts() const {
  if (problem_.contacts.empty()) return {FrozenContact::open};
  return {FrozenContact::open, FrozenContact::sticking};
}

/// The scene with the column's value and, if given, another step.
scene::Problem StabilityStudy::variant(std::size_t column, std::optional<double> step_s) {
  std::vector<scene::Override> changes;
  std::visit([&](const auto& value) { changes.push_back({against_.key, value}); }, against_.values[column]);
  if (step_s) changes.push_back({"time.step_s", *step_s});
  for (const char* output : {"output.axial_stress_every", "output.probes_every"})
    changes.push_back({output, 0.0});  // its windows are no run
  const std::string path = results_.file(fmt::format("variants/{:04}.toml", ++variants_));
  scene::write_variant(problem_.scene.path, changes, path);
  return scene::build_problem(scene::load_scene(path));
}

void StabilityStudy::measure(std::size_t column, const scene::Problem& problem,
                             const std::vector<FrozenContact>& contacts) {
  const auto plans = scene::plan_participants(problem);
  const double edge_s = critical_window_s(problem, plans);
  for (const auto& measured : measure_stability(problem, plans, contacts, results_)) {
    points_.push_back({column, problem.clock.size_s(1), edge_s, measured.frozen_contact, measured.radius});
    print(points_.back());
  }
}

void StabilityStudy::run_column(std::size_t column) {
  double unit_s = 1.0;
  if (by_courant() && !problem_.joints.empty()) {
    throw ConfigError(
        fmt::format("--sweep: found courant, a share of a critical time step, and the foreign body \"{}\", whose "
                    "critical time step the scene does not know; allowed: time.step_s=LOW:HIGH:COUNT",
                    problem_.joints.front().foreign));
  }
  if (by_courant()) {
    const auto problem = variant(column, {});
    unit_s = critical_window_s(problem, scene::plan_participants(problem));
    if (!std::isfinite(unit_s)) {
      throw ConfigError(
          fmt::format("--sweep: found courant, but nothing is explicit with {} = {}; allowed: "
                      "time.step_s=LOW:HIGH:COUNT",
                      against_.key, text_of(against_.values[column])));
    }
  }
  for (const auto& value : steps_.values) {
    measure(column, variant(column, std::get<double>(value) * unit_s), contacts());
  }
}

/// Halves the interval between the last stable step before the first unstable one and that one.
void StabilityStudy::bisect(std::size_t column, FrozenContact contact) {
  Edge edge{column, contact, 0.0, 0.0, 0.0};
  for (const auto& point : points_) {
    if (point.column != column || point.contact != contact || edge.unstable_s > 0.0) continue;
    edge.predicted_s = point.predicted_edge_s;
    if (point.radius.known()) (point.radius.stable() ? edge.stable_s : edge.unstable_s) = point.step_s;
  }
  while (edge.stable_s > 0.0 && edge.unstable_s > edge_ratio * edge.stable_s) {
    measure(column, variant(column, 0.5 * (edge.stable_s + edge.unstable_s)), {contact});
    if (!points_.back().radius.known()) break;
    (points_.back().radius.stable() ? edge.stable_s : edge.unstable_s) = points_.back().step_s;
  }
  edges_.push_back(edge);
}

void StabilityStudy::print_participants() const {
  fmt::print("{:<16} {:<9} {:>18} {:>18}\n", "participant", "role", "by Lanczos [s]", "element bound [s]");
  const auto plans = scene::plan_participants(problem_);
  for (const auto& p : plans) {
    fmt::print("{:<16} {:<9} {:>18} {:>18}\n", p.name, name_of(p.role), step_text(p.critical_time_step_s),
               step_text(scene::element_bound_time_step(problem_, problem_.scene.participant(p.name))));
  }
  const double critical_s = scene::critical_time_step(plans);
  fmt::print("critical time step of the scene{} {} s\n\n", problem_.joints.empty() ? "" : " without its foreign bodies",
             step_text(critical_s));
  fmt::print("{:<{}} {:>12} {:>9} {:<9} {:>12} {:>11} {:<9} {}\n", against_.key, label_width(), "step [s]", "Courant",
             "contact", "growth", "resolution", "verdict", "method");
}

void StabilityStudy::print(const Point& p) const {
  const std::string method = p.radius.method == "exact" ? fmt::format("exact, {} unknowns", p.radius.unknowns)
                                                        : fmt::format("{}, {} unknowns, {} windows", p.radius.method,
                                                                      p.radius.unknowns, p.radius.windows);
  fmt::print("{:<{}} {:>12.6g} {:>9.5f} {:<9} {:>12.3e} {:>11.1e} {:<9} {}\n", text_of(against_.values[p.column]),
             label_width(), p.step_s, p.step_s / p.predicted_edge_s, name_of(p.contact), p.radius.growth(),
             p.radius.resolution, p.radius.verdict(), method);
  std::fflush(stdout);
}

void StabilityStudy::print(const Edge& e) const {
  std::string measured = fmt::format("between {:.6g} and {:.6g} s", e.stable_s, e.unstable_s);
  if (e.unstable_s == 0.0) measured = "above the sweep";
  if (e.stable_s == 0.0) measured = "below the sweep";
  fmt::print("{:<{}} contact {:<9} edge predicted {} s, measured {}\n", text_of(against_.values[e.column]),
             label_width(), name_of(e.contact), step_text(e.predicted_s), measured);
}

void StabilityStudy::run() {
  print_participants();
  for (std::size_t column = 0; column < against_.values.size(); ++column) {
    run_column(column);
    for (const auto contact : bisects_ ? contacts() : std::vector<FrozenContact>{}) bisect(column, contact);
  }
  if (!edges_.empty()) fmt::print("\n");
  for (const auto& edge : edges_) print(edge);
  for (const auto& note : notes()) fmt::print("{}\n", note);
}

/// All that is known of the protocols that took part.
std::vector<std::string> StabilityStudy::notes() const {
  std::vector<std::string> names{problem_.scene.coupling.protocol.name}, texts;
  if (against_.key == "coupling.protocol") {
    names.clear();
    for (const auto& value : against_.values) names.push_back(text_of(value));
  }
  for (const auto& name : names) {
    const auto& trouble = scene::protocol_traits(name).trouble;
    if (!trouble.empty()) texts.push_back(fmt::format("protocol {} {}", name, trouble));
  }
  const auto unknown = std::count_if(points_.begin(), points_.end(), [](const Point& p) { return !p.radius.known(); });
  if (unknown > 0) {
    texts.push_back(fmt::format(
        "{} of {} points are unknown: what a window does is not linear in the states that were loaded, to a resolution "
        "of {:g}; a participant that does not load what it is given looks like this (`{} check-participant` tries it)",
        unknown, points_.size(), SpectralRadius::coarsest_resolution, command_name));
  }
  return texts;
}

std::string StabilityStudy::csv() const {
  std::string text = fmt::format(
      "{},step_s,courant,predicted_edge_s,contact,spectral_radius,growth_per_window,resolution,verdict,method,unknowns,"
      "windows\n",
      against_.key);
  for (const auto& p : points_) {
    text += fmt::format("{},{:.17g},{:.17g},{:.17g},{},{:.17g},{:.6e},{:.3e},{},{},{},{}\n",
                        text_of(against_.values[p.column]), p.step_s, p.step_s / p.predicted_edge_s, p.predicted_edge_s,
                        name_of(p.contact), p.radius.value, p.radius.growth(), p.radius.resolution, p.radius.verdict(),
                        p.radius.method, p.radius.unknowns, p.radius.windows);
  }
  return text;
}

report::StabilityMap StabilityStudy::map() const {
  report::StabilityMap map;
  map.title = std::filesystem::path(problem_.scene.path).stem().string();
  map.step_title = by_courant() ? "Courant number: step / critical time step" : "step [s]";
  map.against_title = against_.key;
  map.logarithmic = against_.logarithmic;
  map.notes = notes();
  for (const auto& value : against_.values) {
    map.against.push_back(text_of(value));
    if (const auto* number = std::get_if<double>(&value)) map.against_number.push_back(*number);
  }
  const auto on_axis = [this](double step_s, double edge_s) { return by_courant() ? step_s / edge_s : step_s; };
  for (const auto& p : points_) {
    const std::string contact(name_of(p.contact));
    if (p.radius.known()) {
      map.cells.push_back(
          {contact, p.column, on_axis(p.step_s, p.predicted_edge_s), p.radius.growth(), p.radius.stable()});
    }
    if (!std::isfinite(p.predicted_edge_s)) continue;
    const report::StabilityEdge edge{contact, p.column, on_axis(p.predicted_edge_s, p.predicted_edge_s), "predicted"};
    const auto same = [&edge](const report::StabilityEdge& other) {
      return other.contact == edge.contact && other.column == edge.column && other.step == edge.step;
    };
    if (std::none_of(map.edges.begin(), map.edges.end(), same)) map.edges.push_back(edge);
  }
  for (const auto& e : edges_) {
    if (e.stable_s == 0.0 || e.unstable_s == 0.0) continue;
    map.edges.push_back({std::string(name_of(e.contact)), e.column,
                         on_axis(0.5 * (e.stable_s + e.unstable_s), e.predicted_s), "measured"});
  }
  return map;
}

void StabilityStudy::write_files() const {
  write_atomically(results_.file("stability.csv"), csv());
  write_atomically(results_.file("stability.json"), report::to_json(map()));
  write_atomically(results_.file("stability.html"), report::stability_page(map()));
}

}  // namespace

void study_stability(const StabilityRequest& request) {
  const auto problem = load_problem(request.scene);
  const std::string stem = std::filesystem::path(problem.scene.path).stem().string();
  std::vector<std::string> names = {"stability.csv", "stability.json", "stability.html", "variants/#.toml"};
  for (const auto& participant : problem.scene.participants) {
    names.push_back("logs/" + participant.name + ".log");
    names.push_back("keys/" + participant.name + ".key");
  }
  const ResultsDirectory results(request.out.empty() ? "out/" + stem + "_stability" : request.out, names,
                                 {problem.scene.path});
  StabilityStudy study(request, problem, results);
  try {
    study.run();
  } catch (...) {
    study.write_files();  // the points so far
    throw;
  }
  study.write_files();
  fmt::print("results in {}: stability.csv, stability.json, stability.html, variants/\n", results.path());
}

}  // namespace ricochet::coupler
