// own_loop_spring --scene SCENE --name NAME --connect ENDPOINT: the participant of spring_mass_project/spring_mass.cpp,
// written as a code that owns its time loop.
#include <cstdio>

#include "common/base/error.hpp"
#include "common/participant/own_loop.hpp"

using namespace ricochet::participant;

namespace {

constexpr double stiffness = 206.8e9 * 6.4516e-4 / 0.1905, mass = 7844.066 * 6.4516e-4 * 0.1905 / 2;

Description describe(const std::string& name) {
  Description d;
  d.name = name;
  d.role = Role::explicit_solver;
  d.solver = "own_loop_spring";
  d.bodies = {"left"};
  d.interface_body = {0};
  d.interface_position_m = {-0.0635};
  d.interface_mass_kg = {mass};
  d.critical_time_step_s = 3e-5;
  d.capabilities = {Capability::repeat_window};
  d.record_columns = {"mass_kg/left", "energy_kinetic_j/left", "energy_strain_j/left", "energy_interface_j/left",
                      "momentum_n_kg_m_s/left"};
  return d;
}

struct State {
  double u = 0, v = 5.13588, a = 0, link = 0, force = 0, work = 0;

  /// One step of central differences, with the link's displacement at its end.
  void step(double dt, double link_end) {
    u += dt * v + 0.5 * dt * dt * a;
    v += 0.5 * dt * a;
    const double force_end = stiffness * (link_end - u);
    work += 0.5 * (force + force_end) * (link_end - link);
    link = link_end;
    force = force_end;
    a = force / mass;
    v += 0.5 * dt * a;
  }
  [[nodiscard]] std::vector<double> record(double dt) const {
    const double stretch = link - u, staggered = 0.5 * dt * a;
    return {mass, 0.5 * mass * (v * v - staggered * staggered), 0.5 * stiffness * stretch * stretch, work, mass * v};
  }
};

int run(const Arguments& arguments) {
  State state, saved;
  OwnLoop loop(describe(arguments.name), arguments.options);
  loop.initialize({{state.force}, {}, {}});
  while (loop.ongoing()) {
    if (loop.must_save()) saved = state;
    state.step(loop.max_time_step(), loop.read()[0]);
    loop.write({{state.force}, {}, {}}, state.record(loop.setup().clock.size_s()));
    loop.advance();
    if (loop.must_restore()) state = saved;
  }
  return loop.finalize();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(parse_arguments(argc, argv));
  } catch (const ricochet::Error& error) {  // the loop has told the coupler
    std::fprintf(stderr, "own_loop_spring: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
