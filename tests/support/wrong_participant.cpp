// wrong_participant --scene SCENE --name FLAW --connect ENDPOINT: a shipped solver, with one thing about its body or
// its link that is wrong. Tests have it started in the place of that solver; its name in the scene says which. With
// WRONG_STIFFNESS=FACTOR in the environment its bodies are so much stiffer, and it declares no critical step.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "common/base/error.hpp"
#include "common/participant/participant.hpp"
#include "common/problem/problem.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "implicit_solver/implicit_solver.hpp"

namespace ricochet::participant {
namespace {

using scene::Problem;

void scale_stiffness(Problem& problem, double factor) {
  for (auto& body : problem.bodies) body.material.youngs_modulus_pa *= factor;
}

void scale_mass(Problem& problem, double factor) {
  for (auto& body : problem.bodies) body.material.density_kg_m3 *= factor;
}

void make_per_radian(Problem& problem) {
  for (auto& body : problem.bodies) body.section.measure /= 2.0 * M_PI;
}

void make_slower(Problem& problem) {
  for (auto& body : problem.bodies) body.initial_velocity_m_s *= 0.99;
}

void without_gravity(scene::Scene& scene) {
  for (auto& body : scene.bodies) body.gravity_m_s2.assign(body.gravity_m_s2.size(), 0.0);
}

void without_supports(scene::Scene& scene) {
  for (auto& body : scene.bodies) body.supports.clear();
}

const std::map<std::string, std::function<void(scene::Scene&)>> wrong_scenes = {
    {"without_gravity", without_gravity},
    {"without_supports", without_supports},
};

const std::map<std::string, std::function<void(Problem&)>> wrong_bodies = {
    {"lighter", [](Problem& problem) { scale_mass(problem, 0.5); }},
    {"stiffer", [](Problem& problem) { scale_stiffness(problem, 1.01); }},
    {"heavier", [](Problem& problem) { scale_mass(problem, 1.01); }},
    {"per_radian", make_per_radian},
    {"slower", make_slower},
};

/// Rows of nodes in the other order.
std::vector<double> reversed(const std::vector<double>& values, std::size_t components) {
  std::vector<double> result;
  for (std::size_t i = values.size() / components; i-- > 0;) {
    for (std::size_t c = 0; c < components; ++c) result.push_back(values[i * components + c]);
  }
  return result;
}

/// All first components, then all second ones.
std::vector<double> by_component(const std::vector<double>& values, std::size_t components) {
  std::vector<double> result;
  for (std::size_t c = 0; c < components; ++c) {
    for (std::size_t i = c; i < values.size(); i += components) result.push_back(values[i]);
  }
  return result;
}

std::unique_ptr<Participant> solver_of(Problem problem, const std::string& name) {
  if (problem.scene.participant(name).role == Role::implicit_solver)
    return std::make_unique<implicit_solver::ImplicitSolver>(std::move(problem), name);
  return std::make_unique<explicit_solver::ExplicitSolver>(std::move(problem), name);
}

class Wrong : public Participant {
 public:
  Wrong(Problem problem, const std::string& flaw) : flaw_(flaw), solver_(solver_of(std::move(problem), flaw)) {}

  Description describe() override {
    auto d = solver_->describe();
    components_ = static_cast<std::size_t>(d.components);
    if (std::getenv("WRONG_STIFFNESS")) d.critical_time_step_s = 0.0;
    if (flaw_ == "interface_heavier") scale(d.interface_mass_kg, 1.01);
    if (flaw_ == "interface_twice") scale(d.interface_mass_kg, 2.0);
    if (flaw_ == "long_step") d.critical_time_step_s *= 0.5;
    if (flaw_ == "reversed_positions") {  // of each of two equally large bodies
      auto& all = d.interface_position_m;
      const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
      const auto first = reversed({all.begin(), middle}, components_),
                 second = reversed({middle, all.end()}, components_);
      std::copy(second.begin(), second.end(), std::copy(first.begin(), first.end(), all.begin()));
    }
    if (flaw_ == "far_place") d.interface_position_m.back() += 1e-4;
    if (flaw_ == "near_place") d.interface_position_m.back() += 1e-9;
    if (flaw_ == "in_millimetres") scale(d.interface_position_m, 1e3);
    if (flaw_ == "swapped_columns" || flaw_ == "turned") {
      auto& x = d.interface_position_m;
      for (std::size_t i = 0; i < x.size(); i += 2) std::swap(x[i], x[i + 1]);
      for (std::size_t i = 0; flaw_ == "turned" && i < x.size(); i += 2) x[i] *= -1.0;
    }
    if (flaw_ == "short_of_a_node") {
      d.interface_body.pop_back();
      d.interface_mass_kg.pop_back();
      d.interface_position_m.resize(d.interface_position_m.size() - components_);
    }
    if (flaw_ == "owns_nothing") d.contact_owner = false;
    leave_out_columns(d.record_columns);
    return d;
  }
  void initialize(const Setup& setup, LinkOutput& output) override {
    if (flaw_ == "late") sleep(3);
    if (flaw_ == "tells_what_it_is_told") {
      std::fprintf(stderr, "directions");
      for (const double value : setup.directions) std::fprintf(stderr, " %g", value);
      std::fprintf(stderr, "; places");
      for (const double value : setup.scene_position_m) std::fprintf(stderr, " %g", value);
      std::fprintf(stderr, "\n");
    }
    solver_->initialize(mine(setup), output);
    change(output);
  }
  void reconfigure(const Setup& setup) override { solver_->reconfigure(mine(setup)); }
  void synchronise(Integration integration, const std::vector<double>& link_input, LinkOutput& output) override {
    auto input = link_input;
    if (flaw_ == "pushes") scale(input, -1.0);
    solver_->synchronise(flaw_ == "stays_implicit" ? Integration::implicit_newmark : integration, input, output);
    change(output);
  }
  void advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) override {
    still_ = flaw_ == "never_moves";
    if (still_) solver_->synchronise(Integration::explicit_central, link_input, output);
    if (!still_) solver_->advance(window, link_input, output);
    change(output);
    if ((flaw_ == "turns_wrong" || flaw_ == "tells_no_link") && window > 74) scale(output.value, -1.0);
    if (flaw_ == "leaks" && window > 74) output.value.front() += 5.0;  // which nothing gives
  }
  void accept() override {
    if (!still_) solver_->accept();
    advanced_ = true;
  }
  [[nodiscard]] ContactStatus contact_status() const override { return solver_->contact_status(); }
  void record(std::vector<double>& row) override {
    solver_->record(row);
    if (flaw_ == "tells_more_energy") row[1] *= 1.01;
    for (std::size_t i = left_out_.size(); i-- > 0;) row.erase(row.end() - static_cast<std::ptrdiff_t>(left_out_[i]));
  }
  void axial_stress(std::vector<double>& row) override { solver_->axial_stress(row); }
  void load_state(const std::vector<double>& state, FrozenContact contact) override {
    if (flaw_ != "loads_nothing") solver_->load_state(state, contact);
    advanced_ = false;
  }
  void read_state(std::vector<double>& state, std::vector<double>& scale) override {
    solver_->read_state(state, scale);
    if (flaw_ == "stays_loaded" && advanced_) state[0] += 1.0 / scale[0];
  }
  std::string save_state() override { return solver_->save_state(); }
  void restore_state(std::string_view bytes) override { solver_->restore_state(bytes); }
  void advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input,
                       LinkOutput& output) override {
    solver_->advance_substep(window, substep, link_input, output);
    if (flaw_ == "skips_a_substep" && substep >= 2) scale(output.velocity_m_s, 0.9);
  }
  void finish() override { solver_->finish(); }

 private:
  /// The setup that the solver is told.
  [[nodiscard]] Setup mine(const Setup& setup) const {
    Setup mine = setup;
    if (flaw_ == "one_step") {  // of as many as there should be
      mine.clock = setup.clock.size_s() / setup.substeps;
      mine.substeps = 1;
    }
    if (flaw_ == "short_steps") mine.clock = 0.9 * mine.clock.size_s();
    if (flaw_ == "long_steps" || flaw_ == "two_long_steps") mine.clock = 1.1 * mine.clock.size_s();
    if (flaw_ == "two_long_steps") mine.substeps = 2;
    if (flaw_ == "ignores_stiffness") mine.interface_stiffness.clear();
    return mine;
  }

  /// And notes where they stand, counted from the end of a row, the last one first.
  void leave_out_columns(std::vector<std::string>& columns) {
    const std::map<std::string, std::string> quantities = {{"tells_no_strain", "energy_strain_j/"},
                                                           {"tells_no_momentum", "momentum_n_kg_m_s/"},
                                                           {"tells_no_link", "energy_interface_j/"}};
    const auto quantity = quantities.find(flaw_);
    if (quantity == quantities.end()) return;
    for (std::size_t i = columns.size(); i-- > 0;) {
      if (columns[i].rfind(quantity->second, 0) != 0) continue;
      left_out_.insert(left_out_.begin(), columns.size() - i);
      columns.erase(columns.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
  static void scale(std::vector<double>& values, double factor) {
    for (double& value : values) value *= factor;
  }
  void change(LinkOutput& output) const {
    if (flaw_ == "wrong_sign") scale(output.value, -1.0);
    if (flaw_ == "is_not_linear") output.value[output.value.size() / 2] += 1e3 * std::abs(output.value.front());
    if (flaw_ == "one_pulls") output.value.front() *= -1.0;
    if (flaw_ == "reversed_rows") output.value = reversed(output.value, components_);
    if (flaw_ == "rows_by_component") output.value = by_component(output.value, components_);
  }
  std::string flaw_;
  std::size_t components_ = 1;
  std::unique_ptr<Participant> solver_;
  bool advanced_ = false;  ///< since a state was loaded
  bool still_ = false;     ///< it never moves
  std::vector<std::size_t> left_out_;
};

std::unique_ptr<Participant> make(Arguments& arguments) {
  auto scene = scene::load_scene(arguments.scene);
  const auto wrong_scene = wrong_scenes.find(arguments.name);
  if (wrong_scene != wrong_scenes.end()) wrong_scene->second(scene);
  auto problem = scene::build_problem(scene);
  const auto wrong = wrong_bodies.find(arguments.name);
  if (wrong != wrong_bodies.end()) wrong->second(problem);
  if (const char* factor = std::getenv("WRONG_STIFFNESS")) scale_stiffness(problem, std::strtod(factor, nullptr));
  return std::make_unique<Wrong>(std::move(problem), arguments.name);
}

}  // namespace
}  // namespace ricochet::participant

int main(int argc, char** argv) {
  return ricochet::participant::participant_main(argc, argv, ricochet::participant::make);
}
