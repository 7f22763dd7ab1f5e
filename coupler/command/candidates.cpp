#include "coupler/command/candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>

#include "common/base/error.hpp"
#include "common/check/check.hpp"
#include "coupler/command/announcer.hpp"
#include "coupler/command/cost_text.hpp"
#include "coupler/command/impact_text.hpp"
#include "coupler/study/companions.hpp"

namespace ricochet::coupler {
namespace {

constexpr const char* predicting = "predicting the cost of each protocol and step";

/// The numbers of elements for one mesh; none where the scene's own are the only ones.
std::vector<scene::Override> changes_of_mesh(const scene::Scene& scene, double times) {
  if (!scene.mesh_open() && times == 1.0) return {};
  auto changes = *with_elements(scene, times);
  if (scene.mesh_open()) changes.push_back({"accuracy.elements_times", std::vector{1.0}});
  return changes;
}

/// The proposal's problem, `factor` times as coarse as it is meant.
scene::Problem problem_of(GivenScene given, const scene::Scene& scene, const Proposal& proposal, int factor = 1) {
  given.add(proposal.changes(scene, factor));
  return given.load();
}

/// Why the proposal has no pilots: its coarsest mesh cannot be built. Empty: it has.
std::string why_no_pilot(const GivenScene& given, const scene::Scene& scene, const Proposal& proposal) {
  try {
    static_cast<void>(scene::plan(problem_of(given, scene, proposal, coarsest_pilot)));
    return {};
  } catch (const Error& error) {
    return with_times(coarsest_pilot) + ": " + reason_of(error.what());
  }
}

/// Cost of the baselines. Where the scene leaves the protocol open, its step may be one that the default protocol
/// does not bear, and another mesh may not bear the scene's.
cost::PredictedCost predict_baselines(GivenScene given, const scene::Problem& problem,
                                      const cost::MachineSpeed& speed) {
  const auto predicted = [&](const scene::Problem& of) {
    return cost::predict_cost(of, scene::plan(of), expected_end_s(of), speed);
  };
  const bool open = problem.scene.mesh_open();
  if (problem.scene.protocol_given() && !open) return predicted(problem);
  try {
    return predicted(open ? given.load() : problem);
  } catch (const ConfigError&) {
    given.set.emplace_back("coupling.protocol=all_implicit");
    return predicted(given.load());
  }
}

/// Refused ones last.
bool costs_less(const Proposal& a, const Proposal& b) {
  return a.runs() != b.runs() ? a.runs() : a.predicted_s < b.predicted_s;
}

}  // namespace

std::vector<scene::Override> Proposal::changes(const scene::Scene& scene, int factor) const {
  return with(changes_of_mesh(scene, elements_times / factor),
              {{"coupling.protocol", protocol}, {"time.step_s", factor * step_s}});
}

std::string with_times(int factor) { return fmt::format("with {} times the element and step", factor); }

std::string reason_of(const std::string& error) {
  const std::string line = error.substr(0, error.find('\n'));
  const auto place = std::min(line.find(".toml:"), line.find(" with --set "));
  return place == std::string::npos ? line : line.substr(line.find(": ", place) + 2);
}

Candidates::Candidates(const GivenScene& given, const scene::Problem& problem, const Freedom& freedom)
    : given_(given), problem_(problem), freedom_(freedom), speed_(cost::measure_speed()) {
  Announcer announcer;
  announcer.begin(predicting);
  const auto& meshes = problem.scene.elements_times;
  const auto not_coarser = std::find_if(meshes.begin(), meshes.end(), [](double times) { return times >= 1.0; });
  const double first = not_coarser == meshes.end() ? meshes.back() : *not_coarser;
  add_first_mesh(first);
  const auto on_first = all_;
  for (const double times : meshes) {
    if (times == first) continue;
    for (const auto& proposal : on_first) add_like(proposal, times);
  }
}

std::optional<Proposal> Candidates::take_next() {
  for (;;) {
    const auto least = std::min_element(all_.begin(), all_.end(), costs_less);
    if (least == all_.end() || !least->runs()) return {};
    if (least->estimated) {
      Announcer announcer;
      announcer.begin(predicting);
      settle(*least);
      continue;
    }
    Proposal next = std::move(*least);
    all_.erase(least);
    return next;
  }
}

std::vector<Proposal> Candidates::take_rest() {
  std::erase_if(all_, [](const Proposal& proposal) { return proposal.estimated; });
  std::stable_sort(all_.begin(), all_.end(), costs_less);
  return std::move(all_);
}

cost::PredictedCost Candidates::baselines_on(double times) const {
  GivenScene given = given_;
  given.add(changes_of_mesh(problem_.scene, times));
  return predict_baselines(given, problem_, speed_);
}

void Candidates::add_first_mesh(double times) {
  const auto& own = problem_.scene.coupling.protocol;
  const bool own_alone = !freedom_.protocols.empty() && !in_own_step(own.name);
  const auto here = own_alone ? cost::PredictedCost{} : baselines_on(times);
  auto protocols = freedom_.protocols;
  if (protocols.empty()) {
    protocols = {"all_explicit", "all_implicit"};
    if (here.local_explicit_s > 0.0 && !own.local_steps) protocols.emplace_back("local_explicit");
    if (own.coupled() || own.local_steps) protocols.push_back(own.name);
  }
  for (const auto& protocol : protocols) {
    if (in_own_step(protocol)) {
      add({protocol, here.all_explicit_step_s, times});
      continue;
    }
    for (const double unscaled_s : freedom_.steps_s) {
      const double step_s = freedom_.one_step ? unscaled_s : unscaled_s / times;
      const bool is_all_explicit = protocol == "local_explicit" && step_s <= here.all_explicit_step_s * (1.0 + 1e-9);
      if (!is_all_explicit || protocols.size() == 1) add({protocol, step_s, times});
    }
  }
  for (auto& proposal : all_) settle(proposal);
}

/// A step that the elements of the first mesh do not bear is too long for these, too: both are in proportion.
void Candidates::add_like(const Proposal& first, double times) {
  if (!first.runs() && !first.without_pilot && !freedom_.one_step) return;
  const double scale = times / first.elements_times;
  Proposal proposal{first.protocol, freedom_.one_step ? first.step_s : first.step_s / scale, times};
  proposal.predicted_s = first.predicted_s * std::pow(scale, fem::components(problem_.scene.model));
  proposal.estimated = true;
  add(std::move(proposal));
}

void Candidates::add(Proposal proposal) {
  if (!freedom_.largest_step_s || proposal.step_s <= *freedom_.largest_step_s || in_own_step(proposal.protocol))
    all_.push_back(std::move(proposal));
}

void Candidates::settle(Proposal& proposal) const {
  const bool step_of_first_mesh = std::exchange(proposal.estimated, false) && in_own_step(proposal.protocol);
  proposal.predicted_s = 0.0;
  proposal.refused = why_no_pilot(given_, problem_.scene, proposal);
  proposal.without_pilot = !proposal.runs();
  if (!proposal.runs()) return;
  try {
    if (step_of_first_mesh) proposal.step_s = baselines_on(proposal.elements_times).all_explicit_step_s;
    const auto problem = problem_of(given_, problem_.scene, proposal);
    const auto plan = scene::plan(problem);
    const auto cost =
        cost::predict_cost(problem, plan, expected_end_s(problem), speed_, contact_durations_s(problem, plan));
    proposal.predicted_s = cost.setup_s + cost.stepping_s();
  } catch (const Error& error) {
    proposal.refused = reason_of(error.what());
  } catch (const std::bad_alloc&) {
    proposal.refused = "its factor does not fit into memory";
  }
}

}  // namespace ricochet::coupler
