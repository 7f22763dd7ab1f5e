#include "coupler/study/step_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "common/check/check.hpp"
#include "common/problem/critical_step.hpp"
#include "coupler/processes/given_scene.hpp"
#include "coupler/results/csv_cell.hpp"
#include "coupler/study/study_case.hpp"

namespace ricochet::coupler {
namespace {

constexpr long long windows_measured = 100;

struct Candidate {
  double step_s = 0.0;
  std::size_t elements = 0, implicit_elements = 0;
  double setup_s = 0.0, window_s = 0.0, predicted_s = 0.0;
  std::string error;  ///< why it cannot be run
};

Candidate measure(const scene::Problem& problem, double step_s, const std::string& folder) {
  const auto& time = problem.scene.time;
  const double windows = std::min(time.end_s / step_s, static_cast<double>(windows_measured));
  StudyCase run(problem.scene.path, {{"time.step_s", step_s}, {"time.end_s", windows * step_s}}, folder);
  if (!run.failed() && run.repeats() == 0) run.compute();
  Candidate candidate{.step_s = step_s, .error = run.error()};
  if (run.failed()) return candidate;
  for (const auto& body : run.problem().bodies) {
    candidate.elements += body.implicit_element.size();
    candidate.implicit_elements += std::count(body.implicit_element.begin(), body.implicit_element.end(), true);
  }
  candidate.setup_s = run.costs().front().setup_s;
  candidate.window_s = run.costs().front().stepping_s / static_cast<double>(run.steps());
  candidate.predicted_s = candidate.setup_s + time.end_s / step_s * candidate.window_s;
  return candidate;
}

std::string to_csv(const std::vector<Candidate>& candidates) {
  std::string text = "step_s,elements,implicit_elements,setup_s,window_s,predicted_s,error\n";
  for (const auto& c : candidates) {
    text += fmt::format("{:.6g},{},{},{:.6g},{:.6g},{:.6g},{}\n", c.step_s, c.elements, c.implicit_elements, c.setup_s,
                        c.window_s, c.predicted_s, csv_cell(c.error));
  }
  return text;
}

void print(const std::vector<Candidate>& candidates, const Candidate& best, double end_s) {
  fmt::print(
      "step and implicit part of least time, from {} windows of each candidate; predicted to {:.6g} s\n{:>12} {:>18} "
      "{:>12} {:>11} {:>14}\n",
      windows_measured, end_s, "step [s]", "implicit elements", "window [us]", "set-up [s]", "predicted [s]");
  for (const auto& c : candidates) {
    if (!c.error.empty()) {
      fmt::print("{:>12.4g} cannot be run: {}\n", c.step_s, c.error);
      continue;
    }
    fmt::print("{:>12.4g} {:>18} {:>12.1f} {:>11.3f} {:>14.3f}{}\n", c.step_s,
               fmt::format("{} of {}", c.implicit_elements, c.elements), 1e6 * c.window_s, c.setup_s, c.predicted_s,
               &c == &best ? "  chosen" : "");
  }
  std::fflush(stdout);
}

}  // namespace

std::vector<double> candidate_steps(std::vector<double> element_steps_s, double largest_s, double safety_factor) {
  std::sort(element_steps_s.begin(), element_steps_s.end());
  std::vector<double> steps = {largest_s};
  for (double level_s = largest_s; !element_steps_s.empty(); level_s *= 0.5) {
    // Elements at or above the last candidate are explicit with it already.
    const auto end = std::lower_bound(element_steps_s.begin(), element_steps_s.end(),
                                      std::min(level_s / safety_factor, steps.back()));
    if (end == element_steps_s.begin()) break;
    steps.push_back(safety_factor * *(end - 1));
  }
  const bool passed_over = !element_steps_s.empty() && element_steps_s.front() < steps.back();  // by halving
  if (passed_over) steps.push_back(safety_factor * element_steps_s.front());
  return steps;
}

std::string choose_step(const scene::Problem& problem, const ResultsDirectory& results) {
  const auto& time = problem.scene.time;
  const int substeps = problem.scene.substeps().fewest;
  std::vector<Candidate> candidates;
  for (const double step_s :
       candidate_steps(scene::element_critical_steps(problem), *time.step_s / substeps, time.safety_factor)) {
    candidates.push_back(measure(problem, substeps * step_s, results.file("calibration")));
  }
  write_atomically(results.file("calibration.csv"), to_csv(candidates));
  const auto best = std::min_element(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.error.empty() != b.error.empty() ? a.error.empty() : a.predicted_s < b.predicted_s;
  });
  print(candidates, *best, time.end_s);
  return write_changed_scene(problem.scene.path, {{"time.step_s", best->step_s}}, results.path());
}

}  // namespace ricochet::coupler
