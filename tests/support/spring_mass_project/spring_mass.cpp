// spring_mass --scene SCENE --name NAME --connect ENDPOINT: the smallest explicit participant. One mass on a spring
// stands for the far three quarters of the left bar of configs/two_bars.toml, x = -0.254 m to -0.0635 m:
//   m u'' = -k (u - u_link),   P = k (u_link - u),   k = E A / L,   m = rho A L / 2 at either end
#include "common/participant/participant.hpp"

using namespace ricochet::participant;

class SpringMass : public Participant {
 public:
  explicit SpringMass(const Arguments& arguments) : name_(arguments.name) {}

  Description describe() override {
    Description d;
    d.name = name_;
    d.role = Role::explicit_solver;
    d.solver = "spring_mass";
    d.solver_version = "1";
    d.bodies = {"left"};
    d.interface_body = {0};
    d.interface_position_m = {-0.0635};
    d.interface_mass_kg = {mass};
    d.critical_time_step_s = 3e-5;  // below sqrt(2 m / k)
    d.capabilities = {Capability::repeat_window};
    d.record_columns = {"mass_kg/left", "energy_kinetic_j/left", "energy_strain_j/left", "energy_interface_j/left",
                        "momentum_n_kg_m_s/left"};
    return d;
  }
  void initialize(const Setup& setup, LinkOutput& output) override {
    dt_ = setup.clock.size_s();
    output.value = {force_};
  }
  void synchronise(Integration, const std::vector<double>& link_input, LinkOutput& output) override {
    trial_ = u_;
    take_link(link_input[0], output);
    finish_window();
  }
  void advance(std::int64_t, const std::vector<double>& link_input, LinkOutput& output) override {
    trial_ = u_ + dt_ * v_ + 0.5 * dt_ * dt_ * a_;  // from the accepted state, however often it is tried
    take_link(link_input[0], output);
  }
  void accept() override {
    v_ += 0.5 * dt_ * a_;
    finish_window();
    v_ += 0.5 * dt_ * a_;
  }
  void record(std::vector<double>& row) override {
    const double stretch = link_ - u_, staggered = 0.5 * dt_ * a_;
    row.insert(row.end(), {mass, 0.5 * mass * (v_ * v_ - staggered * staggered), 0.5 * stiffness * stretch * stretch,
                           work_, mass * v_});
  }

 private:
  void take_link(double link, LinkOutput& output) {
    trial_link_ = link;
    trial_force_ = stiffness * (link - trial_);
    output.value = {trial_force_};
  }
  void finish_window() {
    work_ += 0.5 * (force_ + trial_force_) * (trial_link_ - link_);
    u_ = trial_;
    link_ = trial_link_;
    force_ = trial_force_;
    a_ = force_ / mass;
  }

  static constexpr double stiffness = 206.8e9 * 6.4516e-4 / 0.1905, mass = 7844.066 * 6.4516e-4 * 0.1905 / 2;
  std::string name_;
  double dt_ = 0, u_ = 0, v_ = 5.13588, a_ = 0, link_ = 0, force_ = 0, work_ = 0;
  double trial_ = 0, trial_link_ = 0, trial_force_ = 0;
};

int main(int argc, char** argv) {
  return participant_main(argc, argv, [](const Arguments& a) { return std::make_unique<SpringMass>(a); });
}
