#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "explicit_solver/reduced/reduced_solver.hpp"
#include "implicit_solver/implicit_solver.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace ricochet::fuzz {

inline const std::string small_bars = R"(model = "bar"
[[body]]
name = "left"
material = { youngs_modulus_pa = 200e9, density_kg_m3 = 8000.0 }
area_m2 = 1e-4
mesh = { start_m = -0.03, length_m = 0.03, elements = 3 }
initial_velocity_m_s = [5.0]
[[body]]
name = "right"
material = { youngs_modulus_pa = 200e9, density_kg_m3 = 8000.0 }
area_m2 = 1e-4
mesh = { length_m = 0.03, elements = 3 }
[contact]
surfaces = ["left.end", "right.start"]
[time]
step_s = 1e-6
end_s = 1e-4
)";

/// Their nodes do not lie opposite each other: the contact follows them as they slide.
inline const std::string small_plates = R"(model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.02, length_m = 0.02, height_m = 0.02, elements = [2, 2] }
initial_velocity_m_s = [2.0, 1.0]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.02, height_m = 0.02, elements = [ACROSS, 2] }
[contact]
surfaces = ["lower.end", "upper.start"]
friction_coefficient = 0.3
LAW
[time]
step_s = 1e-6
end_s = 1e-4
)";

inline std::string plates(const std::string& across, const std::string& law, const std::string& more) {
  std::string text = small_plates;
  text.replace(text.find("ACROSS"), 6, across);
  text.replace(text.find("LAW"), 3, law);
  return text + more;
}

/// Every solver of a few small scenes, started, and its state two windows later, which another process would go on
/// from.
class SmallSolvers {
 public:
  SmallSolvers() {
    const std::string hybrid = "[partition]\nimplicit_length_m = { left = 0.01, right = 0.01 }\n";
    const std::string hybrid_plates = "[partition]\nimplicit_length_m = { lower = 0.01, upper = 0.01 }\n";
    const std::string alone = "[coupling]\nprotocol = \"all_explicit\"\n";
    add(small_bars + hybrid);
    add(small_bars + hybrid + "[coupling]\nprotocol = \"prakash_hjelmstad\"\nsubsteps = 2\n");
    add(plates("3", "", hybrid_plates));
    add(plates("2", "multiplier_update = \"massless\"", hybrid_plates));
    add(plates("3", "", alone));
    add(plates("2", "multiplier_update = \"massless\"", alone));
    add(small_bars + hybrid +
        "reduced_modes = { left = 2, right = 1 }\n[coupling]\nprotocol = \"belytschko_mullen\"\n");
    std::string turning = plates("3", "", "[coupling]\nprotocol = \"all_implicit\"\n");
    turning.replace(turning.find("initial_velocity"), 0,
                    "large_rotation = true\ninitial_angular_velocity_rad_s = 3000.0\n");
    add(turning);
  }

  struct Solver {
    std::unique_ptr<participant::Participant> participant;
    std::vector<double> link;
    std::string state;  ///< after the second window
  };
  std::vector<Solver>& all() { return solvers_; }

  /// From a restored state on, one window.
  static void run(Solver& solver, std::int64_t window) {
    participant::LinkOutput output;
    solver.participant->advance(window, solver.link, output);
    solver.participant->accept();
    solver.participant->work_ahead();
    std::vector<double> row;
    solver.participant->record(row);
    (void)solver.participant->contact_status();
    (void)solver.participant->departures();
    (void)solver.participant->outline();
  }

 private:
  void add(const std::string& text) {
    MemoryFile file;
    file.hold(text);
    const auto problem = scene::build_problem(scene::load_scene(file.path()));
    for (const auto& spec : problem.scene.participants) {
      Solver first = started(problem, spec);
      for (std::int64_t window = 1; window <= 2; ++window) run(first, window);
      solvers_.push_back(started(problem, spec));
      solvers_.back().state = first.participant->save_state();
    }
  }
  static Solver started(const scene::Problem& problem, const scene::ParticipantSpec& spec) {
    const auto& scene = problem.scene;
    Solver solver;
    if (spec.role == participant::Role::implicit_solver) {
      solver.participant = std::make_unique<implicit_solver::ImplicitSolver>(problem, spec.name);
    } else if (spec.reduced) {
      solver.participant = std::make_unique<explicit_solver::ReducedSolver>(problem, spec.name);
    } else {
      solver.participant = std::make_unique<explicit_solver::ExplicitSolver>(problem, spec.name);
    }
    const auto description = solver.participant->describe();
    participant::Setup setup;
    setup.clock = problem.clock.size_s();
    setup.substeps = scene.coupling.substeps;
    setup.last_window = 100;
    setup.interface_mass_kg = description.interface_mass_kg;
    const bool forced = spec.role == participant::Role::implicit_solver || scene.coupling.protocol.dual;
    setup.driven_by = forced ? participant::Drive::force : participant::Drive::displacement;
    const bool by_newmark = spec.role == participant::Role::implicit_solver;
    solver.link.assign(description.interface_position_m.size(), 0.0);
    participant::LinkOutput output;
    solver.participant->initialize(setup, output);
    solver.participant->synchronise(
        by_newmark ? participant::Integration::implicit_newmark : participant::Integration::explicit_central,
        solver.link, output);
    return solver;
  }

  std::vector<Solver> solvers_;
};

}  // namespace ricochet::fuzz
