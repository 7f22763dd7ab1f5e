// The second face of the SDK: a solver that owns its time loop gives the history of the one that is called.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <thread>

#include "common/base/error.hpp"
#include "common/participant/own_loop.hpp"
#include "tests/common/participant/scripted_coupler.hpp"
#include "tests/support/places.hpp"
#include "tests/support/private_endpoint.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

std::string program(const std::string& name) { return build_folder() + "/" + name; }

std::string two_bars(const std::string& protocol, const std::string& executable) {
  return with_protocol(config_text("two_bars"), protocol) +
         fmt::format(
             "[[participant]]\nname = \"spring\"\nrole = \"explicit\"\nbodies = [\"left\"]\n"
             "executable = \"{}\"\ndiffering_bodies = [\"left\"]\n",
             executable) +
         "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"right\"]\n"
         "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

class OwnLoops : public testing::TestWithParam<const char*> {};

TEST_P(OwnLoops, GiveTheHistoryOfTheCallbacks) {
  TemporaryFolder folder;
  const auto loop = run_text(two_bars(GetParam(), program("own_loop_spring")), folder, "loop");
  const auto callbacks = run_text(two_bars(GetParam(), program("spring_mass")), folder, "callbacks");
  ASSERT_EQ(loop.column("time_s").size(), callbacks.column("time_s").size());
  ASSERT_GT(loop.largest("contact_force_n"), 1e5);
  for (const auto& [name, values] : callbacks.history) {
    double scale = 1.0, difference = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      scale = std::max(scale, std::abs(values[i]));
      difference = std::max(difference, std::abs(values[i] - loop.column(name)[i]));
    }
    EXPECT_LE(difference, 1e-12 * scale) << name;
  }
}

/// The last two drop trials: of the unit responses at the start, of iterations.
INSTANTIATE_TEST_SUITE_P(Protocols, OwnLoops, testing::Values("hughes_liu", "kim", "belytschko_mullen", "fixed_point"),
                         [](const auto& test) { return std::string(test.param); });

TEST(OwnLoop, KeepsTheContract) {
  TemporaryFolder folder;
  const auto outcome = run_command(
      {ricochet_binary(), "check-participant", "--timeout", "3", "--", program("own_loop_spring"), "--name", "spring"},
      folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
}

TEST(OwnLoop, ExampleIsUnderEightyLines) {
  const std::string text = file_text(source_folder() + "/tests/support/own_loop_spring.cpp");
  EXPECT_GT(text.size(), 0U);
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 80);
}

participant::Description spring() {
  participant::Description d;
  d.name = "spring";
  d.role = participant::Role::explicit_solver;
  d.bodies = {"rod"};
  d.interface_body = {0};
  d.interface_position_m = {0.0};
  d.interface_mass_kg = {1.0};
  return d;
}

TEST(OwnLoop, TellsTheCouplerIfItIsLeftEarly) {
  for (const bool during_setup : {true, false}) {
    participant::OverSocket run(private_endpoint());
    std::thread solver([&] {
      participant::OwnLoop loop(spring(), {run.listener.endpoint(), 10.0, false});
      loop.initialize({{0.0}, {}, {}});
      EXPECT_TRUE(during_setup || loop.ongoing());
    });
    run.meet();
    run.coupler.ask(wire::Kind::describe);
    auto answer = run.coupler.ask(run.coupler.initialize());
    if (!during_setup) answer = run.coupler.ask(run.coupler.synchronise());
    solver.join();
    EXPECT_EQ(answer.kind, wire::Kind::failure);
    EXPECT_THAT(answer.as<wire::Failure>().error_text,
                testing::HasSubstr("the solver left its time loop before the run was over"));
  }
}

/// Between `initialize` and the first question about a window; an answer to `initialize` waits for it.
TEST(OwnLoop, TellsOfALongSetUp) {
  participant::OverSocket run(private_endpoint());
  std::thread solver([&] {
    participant::OwnLoop loop(spring(), {run.listener.endpoint(), 10.0, false});
    EXPECT_THROW(loop.progress("too early"), ConfigError);
    loop.initialize({{0.0}, {}, {}});
    EXPECT_GT(loop.setup().clock.size_s(), 0.0);
    loop.progress("casting", 0.25);
    EXPECT_TRUE(loop.ongoing());
    EXPECT_THROW(loop.progress("too late"), ConfigError);
  });
  run.meet();
  run.coupler.ask(wire::Kind::describe);
  const auto told = run.coupler.ask(run.coupler.initialize());
  const auto answer = run.hear();
  run.coupler.ask(run.coupler.synchronise());
  solver.join();
  ASSERT_EQ(told.kind, wire::Kind::progress);
  EXPECT_EQ(told.as<wire::Progress>().doing, "casting");
  EXPECT_EQ(told.as<wire::Progress>().share_done, 0.25);
  EXPECT_EQ(answer.kind, wire::Kind::initialized);
}

TEST(OwnLoop, ThrowsIfThereIsNoCoupler) {
  participant::OwnLoop loop(spring(), {private_endpoint(), 0.1, false});
  EXPECT_THROW(loop.initialize({{0.0}, {}, {}}), Error);
  EXPECT_FALSE(loop.ongoing());
  EXPECT_EQ(loop.finalize(), static_cast<int>(ExitCode::participant));
}

}  // namespace
}  // namespace ricochet::test
