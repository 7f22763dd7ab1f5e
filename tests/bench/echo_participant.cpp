// echo_participant --scene SCENE --name ROLE_NODES --connect ENDPOINT: a participant that computes nothing. Its name
// says what it is, "explicit_101" or "implicit_101"; its NODES interface nodes of two components stay where they are.
#include <cstdlib>

#include "common/base/error.hpp"
#include "common/participant/participant.hpp"

using namespace ricochet::participant;

namespace {

class Echo : public Participant {
 public:
  explicit Echo(const Arguments& arguments) : name_(arguments.name) {
    const auto line = name_.find('_');
    const auto role = ricochet::find_named<Role>(name_.substr(0, line));
    nodes_ = line == std::string::npos ? 0 : std::atoi(name_.c_str() + line + 1);
    if (!role || nodes_ <= 0) {
      throw ricochet::ConfigError("--name: found \"" + name_ + "\", allowed are explicit_NODES and implicit_NODES");
    }
    role_ = *role;
  }
  Description describe() override {
    Description d;
    d.name = name_;
    d.role = role_;
    d.solver = "echo_participant";
    d.contact_owner = role_ == Role::implicit_solver;
    d.components = 2;
    d.bodies = {"steel"};
    d.critical_time_step_s = role_ == Role::explicit_solver ? 1.0 : 0.0;
    d.record_columns = {"mass_kg/steel", "energy_kinetic_j/steel", "energy_strain_j/steel", "energy_interface_j/steel",
                        "momentum_n_kg_m_s/steel"};
    for (int i = 0; i < nodes_; ++i) {
      d.interface_body.push_back(0);
      d.interface_position_m.insert(d.interface_position_m.end(), {1e-3 * i, 0.0});
      d.interface_mass_kg.push_back(1.0);
    }
    return d;
  }
  void initialize(const Setup&, LinkOutput& output) override { rest(output); }
  void synchronise(Integration, const std::vector<double>&, LinkOutput& output) override { rest(output); }
  void advance(std::int64_t, const std::vector<double>&, LinkOutput& output) override { rest(output); }
  void accept() override {}
  void record(std::vector<double>& row) override { row.insert(row.end(), {1.0, 0.0, 0.0, 0.0, 0.0}); }

 private:
  void rest(LinkOutput& output) const {
    const auto size = static_cast<std::size_t>(2 * nodes_);
    output.value.resize(size);
    if (role_ == Role::explicit_solver) return;
    output.velocity_m_s.resize(size);
    output.acceleration_m_s2.resize(size);
  }
  std::string name_;
  Role role_ = Role::explicit_solver;
  int nodes_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  return participant_main(argc, argv, [](const Arguments& a) { return std::make_unique<Echo>(a); });
}
