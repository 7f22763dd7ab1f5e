#include "coupler/command/cost_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "common/check/check_reach.hpp"
#include "common/cost/predicted_cost.hpp"
#include "coupler/command/impact_text.hpp"
#include "coupler/processes/machine_check.hpp"
#include "coupler/results/history_file.hpp"
#include "coupler/results/theory.hpp"

namespace ricochet::coupler {

double expected_end_s(const scene::Problem& problem) {
  const auto& time = problem.scene.time;
  const auto theory = impact_theory(problem);
  if (!time.until_separated_plus_s || !theory) return time.end_s;
  return std::min(time.end_s,
                  scene::first_contact_s(problem) + theory->contact_duration_s + *time.until_separated_plus_s);
}

namespace {

std::string bytes_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.2g} MB", 1e-6 * bytes) : fmt::format("{:.3g} GB", 1e-9 * bytes);
}

/// Free space on the disk of the present folder [bytes], if the system tells it.
std::optional<double> free_here_bytes() {
  std::error_code error;
  const auto space = std::filesystem::space(".", error);
  if (error) return std::nullopt;
  return static_cast<double>(space.available);
}

}  // namespace

std::string disk_text(const scene::Problem& problem, const cost::PredictedCost& cost,
                      std::optional<double> free_bytes) {
  const auto& output = problem.scene.output;
  const double row_bytes = 20.0 * static_cast<double>(history_columns(history_shape(problem)).size());
  const double times = output.fields_every > 0 ? std::floor(cost.windows / output.fields_every) + 1.0 : 0.0;
  const double files = times * cost.field_files, of_fields = times * cost.field_bytes;
  const double need_bytes = row_bytes * cost.windows / output.history_every + of_fields;
  std::string text = fmt::format("disk: about {}", bytes_text(need_bytes));
  if (files > 0.0) text += fmt::format(", of it {} in {:.0f} files of fields", bytes_text(of_fields), files);
  if (!free_bytes) return text + "\n";
  text += fmt::format("; {} free here\n", bytes_text(*free_bytes));
  if (need_bytes > *free_bytes)
    text += fmt::format("warning: that is more than is free: {}\n",
                        of_fields > 0.5 * need_bytes ? "fewer fields by a larger output.fields_every"
                                                     : "fewer rows by a larger output.history_every");
  return text;
}

std::string cost_text(const scene::Problem& problem, const scene::Plan& plan) {
  const auto known = [](const auto& participant) { return !participant.foreign(); };
  const auto& participants = problem.scene.participants;
  const double nodes_bytes = memory_need_bytes(problem);
  if (!std::all_of(participants.begin(), participants.end(), known)) return memory_text(nodes_bytes) + "\n";
  const auto cost = cost::predict_cost(problem, plan, expected_end_s(problem), cost::measure_speed(),
                                       contact_durations_s(problem, plan));
  std::string text = memory_text(nodes_bytes + cost.factor_bytes) + "\n";
  text += fmt::format("predicted: {:.2g} s for {:.0f} steps of {:.3g} us", cost.stepping_s(), cost.windows,
                      1e6 * cost.window_s);
  for (std::size_t p = 0; p < cost.participants.size(); ++p)
    text += fmt::format("{}\"{}\" {:.3g} us", p == 0 ? "; computing " : ", ", cost.participants[p].name,
                        1e6 * cost.participants[p].window_s);
  const auto& scene = problem.scene;
  if (scene.time.until_separated_plus_s && expected_end_s(problem) == scene.time.end_s)
    text += "; fewer steps if the bodies part before time.end_s";
  if (scene.coupling.protocol.iterated) text += "; with one iteration a step";
  if (scene::yields(problem)) text += "; as if bodies that may yield did so in every step";
  const auto layout = scene.coupling.protocol.layout;
  if (layout != scene::Layout::all_implicit)
    text += fmt::format("\n  all_implicit would take {:.2g} s, {:.2g} times as long", cost.all_implicit_s,
                        cost.all_implicit_s / cost.stepping_s());
  const bool local_steps = scene.coupling.protocol.local_steps;
  if (cost.local_explicit_s > 0.0 && !local_steps)
    text += fmt::format("\n  local_explicit would take {:.2g} s, {:.2g} times as long", cost.local_explicit_s,
                        cost.local_explicit_s / cost.stepping_s());
  if (layout != scene::Layout::all_explicit || local_steps)
    text += fmt::format("\n  all_explicit would take {:.2g} s, {:.2g} times as long, in steps of {:.3g} s",
                        cost.all_explicit_s, cost.all_explicit_s / cost.stepping_s(), cost.all_explicit_step_s);
  return text + "\n" + fmt::format("set-up before the first step: about {:.2g} s\n", cost.setup_s) +
         disk_text(problem, cost, free_here_bytes());
}

}  // namespace ricochet::coupler
