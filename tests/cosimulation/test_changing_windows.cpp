// Windows that change their size: the key `time.changes`, and `resume --step`.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

using testing::AllOf;
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

/// configs/bouncing_bar.toml: impacts of 2 ms, flights of 25 ms.
std::string bouncing(const std::string& protocol, const std::string& step_s, const std::string& flight_step_s = "") {
  std::string text = replaced(config_text("bouncing_bar"), "safety_factor = 0.9\n", "step_s = " + step_s + "\n");
  if (!flight_step_s.empty()) text = with_key(text, "time", "flight_step_s", flight_step_s);
  return with_key(text, "coupling", "protocol", '"' + protocol + '"');
}

/// When the bar comes down again, the last after three bounces [s].
std::vector<double> landings(const RunResult& run) {
  const auto &time = run.column("time_s"), &force = run.column("contact_force_n");
  std::vector<double> found;
  double touched = -1.0;
  for (std::size_t row = 0; row < time.size(); ++row) {
    if (force[row] == 0.0) continue;
    if (time[row] - touched > 5e-3) found.push_back(time[row]);
    touched = time[row];
  }
  return found;
}

/// A sixth of the windows, and as near to what short ones find as these are to each other.
TEST(Flight, TakesLongWindowsForTheAnswerOfShortOnes) {
  const TemporaryFolder folder;
  const RunResult shorter = run_text(bouncing("all_implicit", "2.25e-6"), folder, "shorter"),
                  even = run_text(bouncing("all_implicit", "9e-6"), folder, "even"),
                  flight = run_text(bouncing("all_implicit", "9e-6", "144e-6"), folder, "flight"),
                  coarse = run_text(bouncing("all_implicit", "36e-6"), folder, "coarse");
  const auto windows = [](const RunResult& run) { return run.summary.at("windows").get<int>(); };
  EXPECT_LT(6 * windows(flight), windows(even) + 50);
  EXPECT_THAT(flight.outcome.out, HasSubstr(" windows, the first of 9e-06 s with all_implicit"));
  EXPECT_THAT(even.outcome.out, HasSubstr(" windows of 9e-06 s with all_implicit"));
  EXPECT_LT(windows(flight), windows(coarse));
  const auto exact = landings(shorter), near = landings(even), flown = landings(flight), far = landings(coarse);
  ASSERT_EQ(exact.size(), 4U);
  ASSERT_EQ(flown.size(), 4U);
  const double of_short = std::abs(near.back() - exact.back());
  EXPECT_LT(std::abs(flown.back() - exact.back()), of_short);
  EXPECT_GT(std::abs(far.back() - exact.back()), 2.0 * of_short) << "as many windows of one size";
  EXPECT_NEAR(flown.front(), std::sqrt(2.0 * 7.964e-4 / 9.81), 2.0 * 9e-6) << "no long window meets the plane";
  EXPECT_LT(flight.summary.at("energy_error_highest").get<double>(), 1e-9);
  EXPECT_LT(flight.summary.at("momentum_error_max").get<double>(), 1e-9);
}

/// The rod vibrates in flight as strongly as it flies: fewer windows of one size have less of an error.
TEST(Flight, GainsNothingForABodyThatVibratesInIt) {
  const TemporaryFolder folder;
  const auto rod = [&](const std::string& steps, const std::string& out) {
    const auto text = replaced(replaced(config_text("rod_on_stop"), "elements = 100", "elements = 400"),
                               "safety_factor = 0.9", steps);
    const RunResult run = run_text(with_key(text, "coupling", "protocol", "\"all_implicit\""), folder, out);
    return std::pair(run.summary.at("windows").get<int>(),
                     std::abs(run.summary.at("contact_impulse_n_s").get<double>() / 2.0 - 1.0));
  };
  const auto flight = rod("step_s = 2.25e-3\nflight_step_s = 9e-3", "flight"), even = rod("step_s = 4.5e-3", "even");
  EXPECT_LT(even.first, flight.first);
  EXPECT_LT(even.second, flight.second);
}

class FlightUnder : public testing::TestWithParam<const char*> {};

/// Two bars that fly 0.508 mm at 10.3 m/s before they meet, by windows that `step_s` divides by four in contact.
std::string flying_bars(const std::string& protocol) {
  const auto text = with_key(with_protocol_of_two_steps(config_text("two_bars"), protocol), "time", "step_s",
                             fmt::format("{:.17g}", 0.25 * window_s));
  return with_key(text, "time", "flight_step_s", fmt::format("{:.17g}", window_s));
}

TEST_P(FlightUnder, KeepsForceReleaseAndMomentum) {
  const TemporaryFolder folder;
  const RunResult run = run_text(flying_bars(GetParam()), folder);
  EXPECT_NEAR(run.mean("contact_force_n", 60e-6, 140e-6), force_n, 0.01 * force_n);
  EXPECT_NEAR(run.summary.at("first_contact_s").get<double>(), impact_s, 0.5 * window_s);
  EXPECT_NEAR(run.summary.at("separation_time_s").get<double>(), release_s, window_s);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  const auto windows = run.summary.at("windows").get<int>();
  EXPECT_LT(windows, 300) << "of 450 short ones";
  EXPECT_NEAR(run.summary.at("end_time_s").get<double>(), run.column("time_s").back(), 1e-12);
  EXPECT_GE(run.column("time_s").back(), 250e-6 - 1e-12);
  EXPECT_LT(run.column("time_s").back(), 250e-6 + window_s);
}

TEST_P(FlightUnder, GoesOnToTheSameBytes) {
  const TemporaryFolder folder;
  const auto text = with_key(flying_bars(GetParam()), "checkpoint", "every_windows", "60");
  const RunResult whole = run_text(text, folder, "whole");
  for (const char* end : {"40e-6", "120e-6", "200e-6"}) {  // in flight, in contact, in flight
    const RunResult part = run_text(with_key(text, "time", "end_s", end), folder, "part");
    const auto outcome =
        run_command({ricochet_binary(), "resume", part.folder, "--until", "250e-6"}, folder.path().string());
    ASSERT_EQ(outcome.code, 0) << outcome.error;
    EXPECT_EQ(file_text(part.folder + "/history.csv"), file_text(whole.folder + "/history.csv")) << end;
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, FlightUnder,
                         testing::Values("hughes_liu", "belytschko_mullen", "prakash_hjelmstad", "all_implicit",
                                         "all_explicit"),
                         name_of_protocol);

TEST(Flight, LeavesTheBoundsOfContactToShortWindows) {
  const TemporaryFolder folder;
  const auto penalty = [&](const std::string& flight_step_s) {
    const auto text =
        with_key(with_key(bouncing("all_implicit", "9e-6", flight_step_s), "contact", "enforcement", "\"penalty\""),
                 "contact", "penalty_pa_m", "1e12");
    const auto checked = run_command({ricochet_binary(), "check", folder.write(text)}, folder.path().string());
    EXPECT_EQ(checked.code, 0) << checked.error;
    const auto at = checked.out.find("penalty: ");
    return checked.out.substr(at, checked.out.find('\n', at) - at);
  };
  EXPECT_THAT(penalty("144e-6"), HasSubstr("penalty: sqrt(2 alpha_n/m) dt = "));
  EXPECT_EQ(penalty("144e-6"), penalty(""));
}

TEST(Flight, IsRefusedWhereItCannotBe) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text) {
    const auto run = run_file(folder.write(text), folder);
    EXPECT_EQ(run.outcome.code, 2);
    return run.outcome.error;
  };
  EXPECT_THAT(refused(bouncing("all_implicit", "9e-6", "9e-6")),
              HasSubstr("time.flight_step_s: found 9e-06; allowed: longer than step_s = 9e-06"));
  EXPECT_THAT(refused(bouncing("hughes_liu", "9e-6", "1e-4")),
              AllOf(HasSubstr("time.flight_step_s: found a step of 0.0001"), HasSubstr("allowed: flight_step_s = ")));
  EXPECT_THAT(refused(bouncing("local_explicit", "9e-6", "1e-4")),
              HasSubstr("time.flight_step_s: found steps of other"));
  EXPECT_THAT(refused(with_key(bouncing("all_implicit", "9e-6", "1e-4"), "time", "changes",
                               "[{ from_s = 1e-3, step_s = 1e-6 }]")),
              HasSubstr("without changes"));
  const RunResult run = run_text(
      with_key(bouncing("all_implicit", "9e-6", "144e-6"), "checkpoint", "every_windows", "1000"), folder, "ran");
  const auto outcome = run_command({ricochet_binary(), "resume", run.folder, "--until", "0.12", "--step", "1e-6"},
                                   folder.path().string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr("--step: found 1e-06, with "));
}

}  // namespace
}  // namespace ricochet::test
