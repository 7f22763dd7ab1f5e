#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <string>

#include "common/solver/main.hpp"

namespace ricochet::solver {
namespace {

constexpr const char* scene = R"(model = "bar"
[[body]]
name = "bar"
material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }
mesh = { length_m = 1.0, elements = 4 }
[time]
step_s = 0.1
end_s = 1.0
[coupling]
protocol = "all_implicit"
)";

template <class Thrown>
struct Failing : participant::Participant {
  Failing(scene::Problem, const std::string&, std::optional<double>) { throw Thrown("broken"); }
  participant::Description describe() override { return {}; }
  void initialize(const participant::Setup&, participant::LinkOutput&) override {}
  void synchronise(participant::Integration, const std::vector<double>&, participant::LinkOutput&) override {}
  void advance(std::int64_t, const std::vector<double>&, participant::LinkOutput&) override {}
  void accept() override {}
  void record(std::vector<double>&) override {}
};

/// The code of a solver that throws before it is served, and that of `participant_main` for the same.
template <class Thrown>
std::pair<int, int> codes() {
  const std::string path = testing::TempDir() + "solver_main_" + std::to_string(getpid()) + ".toml";
  std::ofstream(path) << scene;
  const char* arguments[] = {"solver", "--scene", path.c_str(), "--name", "implicit", "--connect", "ipc://@nowhere"};
  const int own = solver_main<Failing<Thrown>>(7, arguments);
  const int general = participant::participant_main(
      7, arguments,
      [](participant::Arguments&) -> std::unique_ptr<participant::Participant> { throw Thrown("broken"); });
  unlink(path.c_str());
  return {own, general};
}

TEST(SolverMain, EndsWithTheCodeThatEveryParticipantEndsWith) {
  EXPECT_EQ(codes<std::runtime_error>(), std::pair(3, 3));
  EXPECT_EQ(codes<ConfigError>(), std::pair(2, 2));
  EXPECT_EQ(codes<ParticipantError>(), std::pair(4, 4));
}

TEST(SolverMain, NeedsAScene) {
  const char* arguments[] = {"solver", "--name", "implicit", "--connect", "ipc://@nowhere"};
  testing::internal::CaptureStderr();
  EXPECT_EQ(solver_main<Failing<std::runtime_error>>(5, arguments), 2);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("--scene is missing"));
}

}  // namespace
}  // namespace ricochet::solver
