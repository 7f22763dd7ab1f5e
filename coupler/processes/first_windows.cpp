#include "coupler/processes/first_windows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "common/base/error.hpp"
#include "coupler/interface/vectors.hpp"
#include "coupler/processes/inside.hpp"
#include "coupler/watch/scene_comparison.hpp"
#include "coupler/watch/tried_causes.hpp"

namespace ricochet::coupler {
namespace {

/// Strain below which differences are rounding: in units of it quantities are compared before anything has happened.
constexpr double least_strain = 1e-9;
constexpr std::int64_t most_windows = 1000;
/// Numbers that are kept for trying causes.
constexpr std::size_t most_kept = 4'000'000;
/// Nodes are matched by the interface map already: this only tells neighbours apart.
constexpr double near_share = 1e-6;

std::size_t unsigned_of(std::ptrdiff_t index) { return static_cast<std::size_t>(index); }

bool single_substeps(const scene::CouplingSettings& coupling) {
  const auto& needed = coupling.protocol.explicit_capabilities;
  return coupling.substeps > 1 && std::find(needed.begin(), needed.end(), Capability::single_substep) != needed.end();
}

double diagonal_m(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position.front(), high = low;
  for (const auto& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return (high - low).norm();
}

/// The parts of a scene that it would lack.
struct Lack {
  const char* what;
  std::function<void(scene::Body&)> take_away;
};

const std::vector<Lack>& lacks() {
  static const std::vector<Lack> list{
      {"it computes as if there were no gravity",
       [](scene::Body& b) { b.gravity_m_s2.assign(b.gravity_m_s2.size(), 0.0); }},
      {"it computes as if there were no tractions", [](scene::Body& b) { b.tractions.clear(); }},
      {"it computes as if there were no supports", [](scene::Body& b) { b.supports.clear(); }},
      {"it computes as if there were no absorbing surfaces", [](scene::Body& b) { b.absorbing.clear(); }},
      {"it starts from rest",
       [](scene::Body& b) { b.initial_velocity_m_s.assign(b.initial_velocity_m_s.size(), 0.0); }}};
  return list;
}

}  // namespace

std::unique_ptr<FirstWindows> FirstWindows::of(const scene::Problem& problem, const Coupling& coupling,
                                               const Link& link, double critical_step_s) {
  const auto& participants = problem.scene.participants;
  const bool other_bodies = std::any_of(participants.begin(), participants.end(),
                                        [](const auto& one) { return !one.differing_bodies.empty(); });
  if (!make_inside() || link.input().empty() || single_substeps(problem.scene.coupling) ||
      (link.implicit() && other_bodies))
    return nullptr;
  std::unique_ptr<FirstWindows> windows(new FirstWindows(problem, coupling, link, critical_step_s));
  if (std::none_of(windows->compared_.begin(), windows->compared_.end(), [](bool compared) { return compared; }))
    return nullptr;
  windows->start(*windows->solver_, windows->expected_);
  windows->compare();
  return windows;
}

FirstWindows::FirstWindows(const scene::Problem& problem, const Coupling& coupling, const Link& link,
                           double critical_step_s)
    : problem_(problem), link_(link), solver_(make_inside()(problem, link.name(), critical_step_s)) {
  match_rows(solver_->describe());
  double length_m = 0.0;
  for (const auto& body : problem.bodies) {
    const auto& bodies = link.description().bodies;
    if (std::find(bodies.begin(), bodies.end(), body.name) == bodies.end()) continue;
    length_m = std::max(length_m, diagonal_m(body.mesh));
    wave_speed_m_s_ = std::max(wave_speed_m_s_, scene::fastest_wave_m_s(body));
  }
  const double dt = coupling.window_size_s();
  look_windows_ = most_windows;
  if (wave_speed_m_s_ > 0.0)
    look_windows_ =
        std::min(look_windows_, static_cast<std::int64_t>(std::ceil(2.0 * length_m / (wave_speed_m_s_ * dt))));
  prepare_setup(coupling);
  const double speed = wave_speed_m_s_ * least_strain;
  if (link.driven_by_force()) {
    quantities_ = {
        {"displacement", "m", speed * dt}, {"velocity", "m/s", speed}, {"acceleration", "m/s^2", speed / dt}};
  } else {
    quantities_ = {{"internal force", "N", largest(link.description().interface_mass_kg.data) * speed / dt}};
  }
}

/// The same body, the same place.
void FirstWindows::match_rows(const participant::Description& reference) {
  const auto& own = link_.description();
  const auto components = static_cast<std::size_t>(own.components);
  const auto nodes = own.interface_body.data.size();
  const double near_m = near_share * largest(own.interface_position_m.data);
  std::vector<bool> taken(reference.interface_body.size(), false);
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto& body = own.bodies[static_cast<std::size_t>(own.interface_body.data[i])];
    const auto is_it = [&](std::size_t j) {
      double apart_m = 0.0;
      for (std::size_t c = 0; c < components; ++c)
        apart_m = std::max(apart_m, std::abs(own.interface_position_m.data[i * components + c] -
                                             reference.interface_position_m[j * components + c]));
      return reference.bodies[static_cast<std::size_t>(reference.interface_body[j])] == body && apart_m <= near_m;
    };
    std::size_t j = 0;
    while (j < taken.size() && !is_it(j)) ++j;
    const bool has = j < taken.size();
    if (has) taken[j] = true;
    for (std::size_t c = 0; c < components; ++c) {
      row_of_.push_back(has ? static_cast<std::ptrdiff_t>(j * components + c) : -1);
      compared_.push_back(has && !may_differ(problem_.scene, body));
    }
  }
  // A solver that is not driven at all its nodes says nothing.
  if (std::find(taken.begin(), taken.end(), false) != taken.end()) compared_.assign(compared_.size(), false);
}

/// Keeps what Coupling has told the participant, in the solver's rows.
void FirstWindows::prepare_setup(const Coupling& coupling) {
  const auto& scene = problem_.scene;
  setup_.protocol = scene.coupling.protocol.name;
  setup_.clock = coupling.clock().size_s(1);
  setup_.substeps = scene.participant(link_.name()).substeps;
  setup_.driven_by = link_.driven_by_force() ? Drive::force : Drive::displacement;
  setup_.separation_windows = scene.coupling.separation_windows;
  setup_.last_window = std::numeric_limits<std::int64_t>::max();
  const auto masses = scene.coupling.protocol.dual ? link_.own_mass_kg() : coupling.summed_mass_kg(link_);
  const auto in_rows = in_its_rows(masses);
  const auto components = static_cast<std::size_t>(scene.components());
  for (std::size_t i = 0; i < in_rows.size(); i += components) setup_.interface_mass_kg.push_back(in_rows[i]);
  if (!link_.implicit() || coupling.interface_stiffness().size() == 0) return;
  const auto dofs = link_.rows().dofs();
  setup_.interface_stiffness.resize(row_of_.size() * row_of_.size());
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    for (std::size_t j = 0; j < dofs.size(); ++j)
      setup_.interface_stiffness[unsigned_of(row_of_[i]) * row_of_.size() + unsigned_of(row_of_[j])] =
          coupling.interface_stiffness()(static_cast<Eigen::Index>(dofs[i]), static_cast<Eigen::Index>(dofs[j]));
  }
}

FirstWindows::Values FirstWindows::in_its_rows(const Values& own) const {
  Values result(unsigned_of(std::count_if(row_of_.begin(), row_of_.end(), [](auto row) { return row >= 0; })), 0.0);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (row_of_[i] >= 0) result[unsigned_of(row_of_[i])] = own[i];
  }
  return result;
}

void FirstWindows::start(participant::Participant& solver, participant::LinkOutput& output) const {
  solver.initialize(setup_, output);
  const auto integration = link_.implicit() ? Integration::implicit_newmark : Integration::explicit_central;
  solver.synchronise(integration, in_its_rows(inputs_.empty() ? link_.input() : inputs_.front()), output);
}

void FirstWindows::look() {
  const auto window = link_.window();
  solver_->advance(window, in_its_rows(link_.input()), expected_);
  solver_->accept();
  compare();
}

std::vector<const FirstWindows::Values*> FirstWindows::found() const {
  if (!link_.driven_by_force()) return {&link_.output()};
  return {&link_.output(), &link_.velocity_m_s(), &link_.acceleration_m_s2()};
}

std::vector<FirstWindows::Difference> FirstWindows::differences(const std::vector<Values>& found,
                                                                const participant::LinkOutput& expected,
                                                                std::vector<Quantity>& quantities) const {
  const Values* of_solver[] = {&expected.value, &expected.velocity_m_s, &expected.acceleration_m_s2};
  std::vector<Difference> result;
  for (std::size_t q = 0; q < quantities.size(); ++q) {
    auto& scale = quantities[q].scale;
    Difference worst;
    for (std::size_t i = 0; i < compared_.size(); ++i) {
      if (!compared_[i]) continue;
      const double right = (*of_solver[q])[unsigned_of(row_of_[i])];
      scale = std::max(scale, std::abs(right));
      if (std::abs(found[q][i] - right) > std::abs(worst.found - worst.expected)) worst = {q, i, found[q][i], right};
    }
    if (std::abs(worst.found - worst.expected) > comparison_tolerance * scale) result.push_back(worst);
  }
  return result;
}

void FirstWindows::compare() {
  std::vector<Values> answer;
  for (const auto* values : found()) answer.push_back(*values);
  const double least = quantities_.back().scale;
  const auto different = differences(answer, expected_, quantities_);
  const bool kept_all = static_cast<std::int64_t>(inputs_.size()) == link_.window();
  if (kept_all && (1 + answer.size()) * (1 + inputs_.size()) * row_of_.size() < most_kept) {
    inputs_.push_back(link_.input());
    answers_.push_back(std::move(answer));
  }
  if (!different.empty()) refuse(different.front());
  if (!last_window_ && quantities_.back().scale > least) last_window_ = link_.window() + look_windows_;
}

void FirstWindows::refuse(const Difference& difference) {
  const auto& description = link_.description();
  const auto components = static_cast<std::size_t>(description.components);
  const auto node = difference.row / components;
  const auto& body = description.bodies[static_cast<std::size_t>(description.interface_body.data[node])];
  const auto x = description.interface_position_m.data.begin() + static_cast<std::ptrdiff_t>(node * components);
  const auto window = link_.window();
  const double time_s = setup_.clock.time_s(window);
  const auto when = window == 0 ? std::string("at the start")
                                : fmt::format("at the end of window {} (t = {:.6g} s, in which waves go {:.3g} m)",
                                              window, time_s, wave_speed_m_s_ * time_s);
  const auto& [name, unit, scale] = quantities_[difference.quantity];
  throw ConfigError(fmt::format(
      "participant '{}', body '{}', interface node {} at ({:.9g}) m, component {}: {} its {} is {:.6g} {}, the scene's "
      "own elements give {:.6g} {} for the same link input{}; if the body is meant to be another than the scene's, add "
      "differing_bodies = [\"{}\"] to its [[participant]]",
      link_.name(), body, node, fmt::join(x, x + static_cast<std::ptrdiff_t>(components), ", "),
      difference.row % components, when, name, difference.found, unit, difference.expected, unit, as_cause(cause()),
      body));
}

std::string FirstWindows::cause() const {
  if (static_cast<std::int64_t>(inputs_.size()) <= link_.window()) return "";
  for (const auto& lack : lacks()) {
    auto scene = problem_.scene;
    for (auto& body : scene.bodies) lack.take_away(body);
    try {
      auto other = scene::build_bodies(scene);
      other.clock = problem_.clock.size_s(1);
      if (explains(other)) return lack.what;
    } catch (const Error&) {  // a scene without it is none
    }
  }
  return "";
}

/// The same inputs give what was found in every window.
bool FirstWindows::explains(const scene::Problem& other) const {
  const auto solver = make_inside()(other, link_.name(), std::nullopt);
  static_cast<void>(solver->describe());
  participant::LinkOutput output;
  auto quantities = quantities_;
  start(*solver, output);
  for (std::size_t window = 0; window < inputs_.size(); ++window) {
    if (window > 0) {
      solver->advance(static_cast<std::int64_t>(window), in_its_rows(inputs_[window]), output);
      solver->accept();
    }
    if (!differences(answers_[window], output, quantities).empty()) return false;
  }
  return true;
}

}  // namespace ricochet::coupler
