// Windows that change their size: the key `time.changes`, and `resume --step`.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

const char* const protocols[] = {"hughes_liu",          "kim",          "kim_predicted",
                                 "belytschko_mullen",   "fixed_point",  "prakash_hjelmstad",
                                 "gravouil_combescure", "all_implicit", "all_explicit"};

std::string name_of_protocol(const testing::TestParamInfo<const char*>& test) { return test.param; }

/// Two rods that are pulled apart, so that nothing but time is discrete: a ramp, no contact.
const char* const rods = R"(model = "bar"
[[body]]
name = "left"
material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }
mesh = { start_m = -1.0, length_m = 1.0, elements = 8 }
support = [{ surface = "start", fixed = ["x"] }]
gravity_m_s2 = [-0.2]
[[body]]
name = "right"
material = { youngs_modulus_pa = 1.0, density_kg_m3 = 1.0 }
mesh = { start_m = 0.0, length_m = 1.0, elements = 8 }
traction = [{ surface = "end", traction_pa = [0.3], amplitude = { time_s = [0.0, 0.5], factor = [0.0, 1.0] } }]
[contact]
surfaces = ["left.end", "right.start"]
initial_gap_m = 0.5
[partition]
implicit_length_m = { left = 0.5, right = 0.5 }
)";

std::string changes(double half_from_s, double back_from_s, double step_s) {
  return fmt::format("[{{ from_s = {}, step_s = {:.17g} }}, {{ from_s = {}, step_s = {:.17g} }}]", half_from_s,
                     0.5 * step_s, back_from_s, step_s);
}

/// Momentum of the two at 32 times up to t = 2, of a run that halves its step at 0.5 and has it back at 1.
std::vector<double> momentum(const std::string& protocol, int windows, const TemporaryFolder& folder) {
  const double step_s = 2.0 / windows;
  std::string text = with_key(rods, "time", "step_s", fmt::format("{:.17g}", step_s));
  text = with_key(with_key(text, "time", "changes", changes(0.5, 1.0, step_s)), "time", "end_s", "2.0");
  text = with_key(with_protocol_of_two_steps(text, protocol), "coupling", "outside_model", "\"go_on\"");
  const RunResult run = run_text(text, folder, protocol + std::to_string(windows));
  EXPECT_EQ(run.summary.at("windows").get<int>(), windows + windows / 4);
  EXPECT_NEAR(run.summary.at("end_time_s").get<double>(), 2.0, 1e-12);
  const auto& time = run.column("time_s");
  const auto& all = run.column("momentum_n_kg_m_s");
  std::vector<double> sampled;
  for (std::size_t row = 0; row < time.size(); ++row) {
    const double nearest = std::round(16.0 * time[row]) / 16.0;
    if (row > 0 && std::abs(time[row] - nearest) < 1e-9) sampled.push_back(all[row]);
  }
  EXPECT_EQ(sampled.size(), 32U);
  return sampled;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

class ChangingWindows : public testing::TestWithParam<const char*> {};

/// Richardson: (p_h - p_h/2) / (p_h/2 - p_h/4) = 2^order.
TEST_P(ChangingWindows, AreOfSecondOrder) {
  const TemporaryFolder folder;
  const auto coarse = momentum(GetParam(), 256, folder), middle = momentum(GetParam(), 512, folder),
             fine = momentum(GetParam(), 1024, folder);
  EXPECT_NEAR(std::log2(difference(coarse, middle) / difference(middle, fine)), 2.0, 0.1);
  EXPECT_GT(difference(coarse, middle), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Protocols, ChangingWindows, testing::ValuesIn(protocols), name_of_protocol);

/// configs/two_bars.toml: force Z v0 from 49.456 us to 148.393 us.
constexpr double window_s = 2.226e-6, impact_s = 49.456e-6, release_s = 148.393e-6, force_n = 1.33453e5;

std::string two_bars_that_change(const std::string& protocol) {
  return with_key(with_protocol_of_two_steps(config_text("two_bars"), protocol), "time", "changes",
                  changes(80e-6, 110e-6, window_s));
}

class ImpactAcrossChanges : public testing::TestWithParam<const char*> {};

/// In contact the windows are halved, and doubled back.
TEST_P(ImpactAcrossChanges, KeepsForceReleaseAndMomentum) {
  const TemporaryFolder folder;
  const RunResult run = run_text(two_bars_that_change(GetParam()), folder);
  EXPECT_NEAR(run.mean("contact_force_n", 60e-6, 140e-6), force_n, 0.01 * force_n);
  EXPECT_NEAR(run.mean("contact_force_n", 80e-6, 90e-6), force_n, 0.05 * force_n) << "no force is lost in between";
  EXPECT_NEAR(run.mean("contact_force_n", 110e-6, 120e-6), force_n, 0.05 * force_n);
  EXPECT_NEAR(run.summary.at("first_contact_s").get<double>(), impact_s, 2.0 * window_s);
  EXPECT_NEAR(run.summary.at("separation_time_s").get<double>(), release_s, 2.0 * window_s);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  const auto& time = run.column("time_s");
  double smallest_s = 1.0;
  for (std::size_t row = 1; row < time.size(); ++row) smallest_s = std::min(smallest_s, time[row] - time[row - 1]);
  EXPECT_NEAR(smallest_s, 0.5 * window_s, 1e-12);
}

/// The state that it goes on from holds for the sizes, too, and for the operators that were measured for them.
TEST_P(ImpactAcrossChanges, GoesOnToTheSameBytes) {
  const TemporaryFolder folder;
  auto text = with_key(two_bars_that_change(GetParam()), "checkpoint", "every_windows", "50");
  text = with_key(text, "time", "end_s", "170e-6");  // window 90; they change after 36 and 63
  const RunResult whole = run_text(text, folder);
  const std::string half = (folder.path() / "half").string();
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", half, checkpoints_in(half).back()));
  const auto outcome = resume(half, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.error, HasSubstr("going on from window 50 "));
  expect_same_results(half, whole.folder);
}

INSTANTIATE_TEST_SUITE_P(Protocols, ImpactAcrossChanges, testing::ValuesIn(protocols), name_of_protocol);

class AnotherStep : public testing::TestWithParam<const char*> {};

/// To the bytes of the run whose scene says so.
TEST_P(AnotherStep, OfAResumedRunIsThatOfAScene) {
  const TemporaryFolder folder;
  auto plain = with_key(with_protocol_of_two_steps(config_text("two_bars"), GetParam()), "checkpoint", "every_windows",
                        "36");  // 80.1 us, in contact
  plain = with_key(plain, "time", "end_s", "130e-6");
  const RunResult whole = run_text(plain, folder, "plain");
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", whole.folder, checkpoints_in(whole.folder).back()));
  std::vector<std::string> command = {ricochet_binary(), "resume", whole.folder, "--step",
                                      fmt::format("{:.17g}", 0.5 * window_s)};
  const auto outcome = run_command(command, folder.path().string());
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const auto from = std::stoi(outcome.error.substr(outcome.error.find("from window ") + 12));
  const RunResult told =
      run_text(with_key(plain, "time", "changes",
                        fmt::format("[{{ from_s = {:.17g}, step_s = {:.17g} }}]", from * window_s, 0.5 * window_s)),
               folder, "told");
  const auto resumed = read_history(whole.folder + "/history.csv");
  for (const auto& [column, values] : told.history) EXPECT_EQ(resumed.at(column), values) << column;
  command.back() = "0";
  const auto stopped = run_command(command, folder.path().string());
  EXPECT_EQ(stopped.code, 2);
  EXPECT_THAT(stopped.error, HasSubstr("--step: found 0, allowed: a number of seconds > 0"));
}

INSTANTIATE_TEST_SUITE_P(Protocols, AnotherStep,
                         testing::Values("hughes_liu", "gravouil_combescure", "all_implicit", "all_explicit"),
                         name_of_protocol);

}  // namespace
}  // namespace ricochet::test
