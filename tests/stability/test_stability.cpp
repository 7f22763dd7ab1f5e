// `ricochet stability` with real processes, against exact limits (docs/limits.md, 6 and 7).
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <map>
#include <regex>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;
using Row = std::map<std::string, std::string>;

std::vector<Row> read_rows(const std::string& path) {
  std::ifstream file(path);
  std::string line, cell;
  std::vector<std::string> names;
  std::vector<Row> rows;
  std::getline(file, line);
  for (std::istringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    auto& row = rows.emplace_back();
    for (const auto& name : names) std::getline(cells, row[name], ',');
  }
  return rows;
}

double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

struct Study {
  Outcome outcome;
  std::string folder;
  std::vector<Row> rows;
};

Study study(const std::string& scene, const TemporaryFolder& folder, std::vector<std::string> options) {
  Study result;
  result.folder = (folder.path() / "stability").string();
  options.insert(options.begin(), {ricochet_binary(), "stability", scene, "--out", result.folder});
  result.outcome = run_command(options, folder.path().string(), 300.0);
  result.rows = read_rows(result.folder + "/stability.csv");
  return result;
}

Outcome check(const std::string& scene, const TemporaryFolder& folder) {
  return run_command({ricochet_binary(), "check", scene}, folder.path().string());
}

/// A bar that is implicit as a whole, and one of which the contact node alone is: the explicit elements begin where the
/// stiff ones are held. A held contact node is heavier by the other bar's, which lifts the limit; by 60 elements less
/// than 1e-4.
std::string bars(const std::string& protocol) {
  return R"(model = "bar"
[[body]]
name = "stiff"
material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }
area_m2 = 1e-4
mesh = { start_m = -0.06, length_m = 0.06, elements = 6 }
[[body]]
name = "soft"
material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }
area_m2 = 1e-4
mesh = { length_m = 0.6, elements = 60 }
initial_velocity_m_s = [-1.0]
[contact]
surfaces = ["stiff.end", "soft.start"]
[partition]
implicit_length_m = { stiff = 1.0, soft = 0.0 }
[time]
end_s = 1e-3
[coupling]
protocol = ")" +
         protocol + "\"\n";
}

class Edge : public testing::TestWithParam<const char*> {};

TEST_P(Edge, IsTwoByTheLargestFrequencyOfTheExplicitElementsWhateverTheStiffnessOfTheOthers) {
  TemporaryFolder folder;
  const auto result = study(
      folder.write(bars(GetParam())), folder,
      {"--sweep", "courant=0.5,0.999,1.001", "--against", "body.stiff.material.youngs_modulus_pa=2e11:2e15:3:log"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 3U * 3U * 2U);
  // Free bar of equal elements with lumped masses: omega_max = 2 c / h, so the limit is h/c.
  const double exact_s = 0.01 / std::sqrt(2e11 / 8000.0);
  for (const auto& row : result.rows) {
    EXPECT_NEAR(number(row, "predicted_edge_s"), exact_s, 1e-8 * exact_s);
    EXPECT_EQ(row.at("verdict"), number(row, "courant") < 1.0 ? "stable" : "unstable")
        << row.at("courant") << " " << row.at("contact") << " " << row.at("growth_per_window");
    EXPECT_LT(number(row, "resolution"), 1e-2) << "growth at 1.001 is 0.09";
    EXPECT_EQ(row.at("method"), "exact");
    if (number(row, "courant") > 1.0) {
      EXPECT_NEAR(number(row, "growth_per_window"), 0.09, 0.009);
    }
  }
  EXPECT_THAT(file_text(result.folder + "/stability.html"), HasSubstr("stability_sticking"));
}

TEST_P(Edge, IsWhereCheckDrawsTheLine) {
  TemporaryFolder folder;
  const auto result = study(folder.write(bars(GetParam())), folder, {"--sweep", "courant=0.999,1.001"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  // Variant 1 is the scene that the Courant number counts from, then one a step.
  const auto below = check(result.folder + "/variants/0002.toml", folder);
  const auto above = check(result.folder + "/variants/0003.toml", folder);
  EXPECT_EQ(below.code, 0) << below.error;
  EXPECT_EQ(above.code, 2);
  const auto edge = fmt::format("{:.6g}", number(result.rows.front(), "predicted_edge_s"));
  EXPECT_THAT(below.out, HasSubstr(edge));
  EXPECT_THAT(above.error, HasSubstr("the critical time step " + edge + " s of participant \"explicit\""));
  EXPECT_THAT(result.outcome.out, HasSubstr("critical time step of the scene " + edge + " s"));
}

// For solids, whose elements beside the contact have Poisson's ratio to widen them.
TEST(SolidEdge, IsMeasuredByBisectionToHalfAPercent) {
  std::string text = "model = \"solid\"\n";
  for (const auto& [name, start, speed] : {std::tuple{"left", 0.0, 10.0}, std::tuple{"right", 0.04, 0.0}}) {
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000 "
        "}}\nmesh = {{ start_m = {}, length_m = 0.04, height_m = 0.01, width_m = 0.01, elements = [1, 2, 6] }}\n"
        "initial_velocity_m_s = [0.0, 0.0, {}]\n",
        name, start, speed);
  }
  text +=
      "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\nimplicit_length_m = { left = 0.014, "
      "right = 0.014 }\n[time]\nend_s = 45e-6\n";
  TemporaryFolder folder;
  const auto result = study(folder.write(text), folder, {"--sweep", "courant=0.6:1.3:3", "--edge"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  const std::regex line("edge predicted ([0-9.e-]+) s, measured between ([0-9.e-]+) and ([0-9.e-]+) s");
  std::smatch edge;
  ASSERT_TRUE(std::regex_search(result.outcome.out, edge, line)) << result.outcome.out;
  EXPECT_NEAR(std::stod(edge[2]), std::stod(edge[1]), 1e-3 * std::stod(edge[1]));
  EXPECT_NEAR(std::stod(edge[3]), std::stod(edge[1]), 5e-3 * std::stod(edge[1]));
}

TEST_P(Edge, IsMeasuredByBisectionToHalfAPercent) {
  TemporaryFolder folder;
  const auto result = study(folder.write(bars(GetParam())), folder, {"--sweep", "courant=0.6:1.3:3", "--edge"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  const std::regex line("edge predicted ([0-9.e-]+) s, measured between ([0-9.e-]+) and ([0-9.e-]+) s");
  int edges = 0;
  for (std::sregex_iterator it(result.outcome.out.begin(), result.outcome.out.end(), line), end; it != end; ++it) {
    const double predicted = std::stod((*it)[1]), stable = std::stod((*it)[2]), unstable = std::stod((*it)[3]);
    EXPECT_LE(unstable / stable, 1.005);
    EXPECT_LE(stable, 1.0002 * predicted);
    EXPECT_GE(unstable, 0.9999 * predicted);
    ++edges;
  }
  EXPECT_EQ(edges, 2) << result.outcome.out;
}

INSTANTIATE_TEST_SUITE_P(Protocols, Edge, testing::Values("hughes_liu", "kim", "belytschko_mullen"),
                         [](const auto& test) { return std::string(test.param); });

/// Graded bars, so that the explicit side's limit is its own; with substeps the window may be as many times longer.
std::string graded_bars(const std::string& protocol, int substeps) {
  std::string text = with_protocol(config_text("two_bars"), protocol);
  for (int body = 0; body < 2; ++body) text = replaced(text, "elements = 20 }", "elements = 10, grading = 0.4 }");
  text = replaced(text, "step_s = 2.226e-6  # Courant number 0.90", "safety_factor = 0.5");
  return with_key(text, "coupling", "substeps", std::to_string(substeps));
}

class DualEdge : public testing::TestWithParam<int> {};

TEST_P(DualEdge, IsThatOfTheExplicitSideAloneForEverySubstepping) {
  TemporaryFolder folder;
  const auto result = study(folder.write(graded_bars("prakash_hjelmstad", GetParam())), folder,
                            {"--sweep", "courant=0.3,0.6,0.9,0.999,1.003"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 10U);
  for (const auto& row : result.rows) {
    EXPECT_EQ(row.at("verdict"), number(row, "courant") < 1.0 ? "stable" : "unstable")
        << row.at("courant") << " " << row.at("contact") << " " << row.at("growth_per_window");
    EXPECT_LT(number(row, "resolution"), 1e-4);
  }
}

INSTANTIATE_TEST_SUITE_P(Substeps, DualEdge, testing::Values(1, 2, 3, 5, 10));

/// Dashpots in central difference: they damp, and the edge stays where it is without them.
TEST(AbsorbingEdge, IsThatOfTheBodyWithoutAbsorbingSurfaces) {
  TemporaryFolder folder;
  for (const char* protocol : {"hughes_liu", "prakash_hjelmstad"}) {
    const std::string text = replaced(std::string(protocol) == "hughes_liu" ? bars(protocol) : graded_bars(protocol, 2),
                                      "[contact]", "[[body.absorbing]]\nsurface = \"end\"\n[contact]");
    const auto result = study(folder.write(text), folder, {"--sweep", "courant=0.9,0.999,1.003"});
    ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
    ASSERT_EQ(result.rows.size(), 6U);
    for (const auto& row : result.rows) {
      EXPECT_EQ(row.at("verdict"), number(row, "courant") < 1.0 ? "stable" : "unstable")
          << protocol << " " << row.at("courant") << " " << row.at("contact") << " " << row.at("growth_per_window");
    }
  }
}

// docs/limits.md, 10: what it dissipates is in SplitOscillator.LosesWhatTheAcceptanceTableSays.
TEST(GravouilCombescure, IsStableOpenAndGrowsWithSubstepsWhileTheContactSticks) {
  TemporaryFolder folder;
  for (const int m : {1, 2}) {
    const std::string scene = folder.write(graded_bars("gravouil_combescure", m));
    const auto result = study(scene, folder, {"--sweep", "courant=0.5,0.9,1.003"});
    ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
    for (const auto& row : result.rows) {
      const bool stable = number(row, "courant") < 1.0 && (m == 1 || row.at("contact") == "open");
      EXPECT_EQ(row.at("verdict"), stable ? "stable" : "unstable")
          << m << " " << row.at("courant") << " " << row.at("contact");
      if (!stable && number(row, "courant") == 0.5) {
        EXPECT_NEAR(number(row, "growth_per_window"), 5e-5, 5e-6);
      }
    }
    const std::string said = check(scene, folder).out;
    EXPECT_EQ(said.find("dissipates with substeps > 1") != std::string::npos, m > 1) << said;
  }
}

TEST(KimPredicted, IsUnstableBelowTheLimitOfTheOthersAndSaidSo) {
  TemporaryFolder folder;
  const auto result = study(source_folder() + "/configs/two_bars.toml", folder,
                            {"--sweep", "courant=0.14,0.5,0.9", "--against", "coupling.protocol=kim,kim_predicted"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 12U);
  const std::map<double, double> growth = {{0.14, 1.1e-6}, {0.5, 2.8e-4}, {0.9, 2.2e-3}};
  for (const auto& row : result.rows) {
    if (row.at("coupling.protocol") == "kim") {
      EXPECT_EQ(row.at("verdict"), "stable") << row.at("courant");
      continue;
    }
    EXPECT_EQ(row.at("verdict"), "unstable");
    const double expected = growth.at(number(row, "courant"));
    if (row.at("contact") == "open") {
      EXPECT_NEAR(number(row, "growth_per_window"), expected, 0.1 * expected);
    }
  }
  EXPECT_THAT(result.outcome.out, HasSubstr("protocol kim_predicted is unstable at almost any time step"));
}

TEST(KimPredicted, GrowsInARunAsMeasuredUntilTheEnergyWatchStopsIt) {
  TemporaryFolder folder;
  auto text = with_protocol(config_text("two_bars"), "kim_predicted");
  text = with_key(text, "coupling", "after_separation", "\"implicit\"");  // else it goes on all explicit, and stable
  text = with_key(text, "time", "end_s", "0.04");
  const auto run = run_file(folder.write(text), folder);
  EXPECT_EQ(run.outcome.code, 3);
  EXPECT_THAT(run.outcome.error, HasSubstr("kim_predicted"));
}

/// Central difference on one mass on a spring: lambda^2 - (2 - (omega dt)^2) lambda + 1 = 0.
TEST(SingleOscillator, HasTheSpectralRadiusOfItsClosedForm) {
  TemporaryFolder folder;
  const std::string text = R"(model = "bar"
[[body]]
name = "rod"
material = { youngs_modulus_pa = 2e11, density_kg_m3 = 8000.0 }
area_m2 = 1e-4
mesh = { length_m = 0.1, elements = 1 }
support = [{ surface = "start", fixed = ["x"] }]
[time]
end_s = 1e-3
[coupling]
protocol = "all_explicit"
)";
  const auto result = study(folder.write(text), folder, {"--sweep", "courant=0.3,0.9,1.001,1.05,1.3"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 5U);
  for (const auto& row : result.rows) {
    const double x = 2.0 * std::pow(number(row, "courant"), 2) - 1.0;
    const double exact = x > 1.0 ? x + std::sqrt(x * x - 1.0) : 1.0;
    EXPECT_NEAR(number(row, "spectral_radius"), exact, 1e-9) << row.at("courant");
    EXPECT_EQ(row.at("unknowns"), "2");
    EXPECT_NEAR(number(row, "predicted_edge_s"), 0.1 / std::sqrt(2e11 / 8000.0) * std::sqrt(2.0), 1e-14);
  }
}

std::string coarse_impact() {
  auto text = config_text("kim_impact");
  for (int body = 0; body < 2; ++body) text = replaced(text, "elements = [10, 160]", "elements = [2, 16]");
  return replaced(text, "step_s = 5.4e-8\n", "");
}

TEST(AxisymmetricImpact, IsStableOpenAndStickingUpToTheLimit) {
  TemporaryFolder folder;
  const auto result = study(folder.write(coarse_impact()), folder, {"--sweep", "courant=0.5,0.99,1.01"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 6U);
  for (const auto& row : result.rows) {
    EXPECT_EQ(row.at("verdict"), number(row, "courant") < 1.0 ? "stable" : "unstable")
        << row.at("courant") << " " << row.at("contact") << " " << row.at("growth_per_window");
    if (number(row, "courant") < 1.0) continue;
    const double x = 2.0 * 1.01 * 1.01 - 1.0;  // the mode of the critical step lies in the explicit elements alone
    EXPECT_NEAR(number(row, "spectral_radius"), x + std::sqrt(x * x - 1.0), 1e-3);
  }
}

TEST(AxisymmetricImpact, OfTenThousandUnknownsIsMeasuredByIteration) {
  TemporaryFolder folder;
  auto text = config_text("kim_impact");
  for (int body = 0; body < 2; ++body) text = replaced(text, "elements = [10, 160]", "elements = [10, 130]");
  text = replaced(text, "step_s = 5.4e-8\n", "");
  const auto result = study(folder.write(text), folder, {"--sweep", "courant=1.01,1.02"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 4U);
  for (const auto& row : result.rows) {
    EXPECT_GT(number(row, "unknowns"), 9000.0);
    EXPECT_EQ(row.at("method"), "Arnoldi");
    const double x = 2.0 * std::pow(number(row, "courant"), 2) - 1.0;
    EXPECT_NEAR(number(row, "spectral_radius"), x + std::sqrt(x * x - 1.0), 1e-3);
  }
}

/// explicit_bar.py with the two functions that `stability` needs.
std::string loadable_bar(const TemporaryFolder& folder) {
  const std::string python = source_folder() + "/common/participant/python";
  auto text = file_text(python + "/explicit_bar.py");
  text = replaced(text, "import numpy", "import sys; sys.path.insert(0, \"" + python + "\")\nimport numpy");
  text = replaced(text, "Description(self.name,", "Description(capabilities=[\"load_state\"], name=self.name,");
  text = replaced(text, "\"explicit\", \"explicit_bar.py\"", "role=\"explicit\", solver=\"loadable_bar.py\"");
  text = replaced(text, "main(ExplicitBar)", R"(
    def load_state(self, state, frozen_contact):
        self.u[self.own], self.v[self.own] = np.split(state, 2)

    def read_state(self):
        root = np.sqrt(self.m[self.own])
        return np.r_[self.u[self.own], self.v[self.own]], np.r_[root / self.dt, root]

main(ExplicitBar))");
  const auto path = folder.write(text, "loadable_bar.py");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

TEST(AnotherLanguage, GivesTheSameSpectralRadius) {
  TemporaryFolder folder;
  const std::string text = with_protocol(config_text("two_bars"), "hughes_liu") +
                           "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  std::string ours = text, python = text;
  for (const std::string body : {"left", "right"}) {
    const std::string entry =
        fmt::format("[[participant]]\nname = \"of_{0}\"\nrole = \"explicit\"\nbodies = [\"{0}\"]\n", body);
    ours += entry;
    python += entry + "executable = \"" + loadable_bar(folder) + "\"\n";
  }
  const auto a = study(folder.write(ours), folder, {"--sweep", "courant=0.9,1.01"});
  const auto b = study(folder.write(python), folder, {"--sweep", "courant=0.9,1.01"});
  ASSERT_EQ(a.outcome.code, 0) << a.outcome.error;
  ASSERT_EQ(b.outcome.code, 0) << b.outcome.error;
  ASSERT_EQ(a.rows.size(), 4U);
  ASSERT_EQ(b.rows.size(), 4U);
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    EXPECT_EQ(a.rows[i].at("unknowns"), b.rows[i].at("unknowns"));
    EXPECT_EQ(a.rows[i].at("verdict"), b.rows[i].at("verdict"));
    EXPECT_NEAR(number(a.rows[i], "spectral_radius"), number(b.rows[i], "spectral_radius"), 1e-6);
  }
}

// ---- what is refused

std::string refused(const std::vector<std::string>& options, const std::string& text = bars("hughes_liu")) {
  TemporaryFolder folder;
  const auto result = study(folder.write(text), folder, options);
  EXPECT_EQ(result.outcome.code, 2) << result.outcome.out;
  return result.outcome.error;
}

TEST(StabilityRefuses, KeysAndRangesThatAreNone) {
  EXPECT_THAT(refused({"--against", "body.stiff.material.youngs_modulus=1e9:1e10:2"}),
              HasSubstr("did you mean \"youngs_modulus_pa\""));
  EXPECT_THAT(refused({"--against", "body.stif.area_m2=1:2:2"}), HasSubstr("did you mean \"stiff\""));
  EXPECT_THAT(refused({"--against", "coupling.protocol=kimm"}), HasSubstr("kimm"));
  EXPECT_THAT(refused({"--sweep", "courant=1.1:0.5:3"}), HasSubstr("--sweep: found \"courant=1.1:0.5:3\""));
  EXPECT_THAT(refused({"--sweep", "step=1:2:3"}), HasSubstr("allowed: courant"));
  EXPECT_THAT(refused({"--edgy"}), HasSubstr("did you mean \"--edge\""));
}

TEST(StabilityRefuses, CourantNumbersOfWhatHasNoLimit) {
  EXPECT_THAT(refused({}, bars("all_implicit")),
              HasSubstr("nothing is explicit with coupling.protocol = all_implicit"));
  TemporaryFolder folder;
  const auto result = study(folder.write(bars("all_implicit")), folder, {"--sweep", "time.step_s=1e-7:1e-3:3:log"});
  EXPECT_EQ(result.outcome.code, 0) << result.outcome.error;
  for (const auto& row : result.rows) {
    EXPECT_EQ(row.at("verdict"), "stable") << row.at("step_s") << " " << row.at("growth_per_window");
  }
}

TEST(AParticipantThatLoadsNothing, IsNotCalledStable) {
  TemporaryFolder folder;
  const auto text = bars("hughes_liu") +
                    "[[participant]]\nname = \"loads_nothing\"\nrole = \"explicit\"\nbodies = [\"soft\"]\n"
                    "executable = \"" +
                    build_folder() +
                    "/wrong_participant\"\n"
                    "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  const auto result = study(folder.write(text), folder, {"--sweep", "courant=0.5,0.9"});
  ASSERT_EQ(result.outcome.code, 0) << result.outcome.error;
  ASSERT_EQ(result.rows.size(), 4U);
  for (const auto& row : result.rows) EXPECT_NE(row.at("verdict"), "stable") << row.at("resolution");
  EXPECT_EQ(result.rows[0].at("verdict"), "unknown");
  EXPECT_THAT(result.outcome.out, HasSubstr("points are unknown: what a window does is not linear in the states"));
}

TEST(StabilityRefuses, AParticipantThatCannotLoadAState) {
  const std::string participants =
      "[[participant]]\nname = \"spring\"\nrole = \"explicit\"\nbodies = [\"soft\"]\n"
      "executable = \"" +
      build_folder() +
      "/spring_mass\"\n"
      "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  EXPECT_THAT(refused({}, bars("hughes_liu") + participants),
              HasSubstr("cannot take part in `ricochet stability`: it lacks the capability \"load_state\" (it has: "
                        "repeat_window)"));
}

}  // namespace
}  // namespace ricochet::test
