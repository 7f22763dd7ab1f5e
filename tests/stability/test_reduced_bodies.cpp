#include <gmock/gmock.h>

#include <regex>

#include "tests/stability/edges.hpp"

// `ricochet stability` of bodies that are their lowest modes: no step is too long.

namespace ricochet::test {
namespace {

struct ReducedScene {
  const char* name;
  std::string text, steps;
};

/// A plate strikes one that is held at its sides.
const std::string plates_of_modes = R"(model = "plane_strain"
[material.steel]
youngs_modulus_pa = 210e9
poisson_ratio = 0.3
density_kg_m3 = 7850.0
[[body]]
name = "low"
material = "steel"
mesh = { start_m = -0.01, length_m = 0.01, height_m = 0.02, elements = [6, 5] }
support = [{ surface = "inner", fixed = ["x", "y"] }]
[[body]]
name = "high"
material = "steel"
mesh = { length_m = 0.02, height_m = 0.02, elements = [6, 10] }
initial_velocity_m_s = [0.0, -0.001]
[contact]
surfaces = ["high.start", "low.end"]
[partition]
implicit_length_m = { low = 0.004, high = 0.004 }
reduced_modes = { low = 20, high = 30 }
[time]
step_s = 1e-6
end_s = 1e-4
[coupling]
protocol = "belytschko_mullen"
)";

class ReducedBodiesAreStable : public testing::TestWithParam<ReducedScene> {};

TEST_P(ReducedBodiesAreStable, AtAnyStep) {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "out").string();
  const Outcome outcome = run_command({ricochet_binary(), "stability", folder.write(GetParam().text), "--out", out,
                                       "--sweep", "time.step_s=" + GetParam().steps},
                                      folder.path().string(), 300.0);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  const std::string rows = file_text(out + "/stability.csv");
  const auto count = [&](const std::string& verdict) {
    const std::regex word("," + verdict + ",");
    return std::distance(std::sregex_iterator(rows.begin(), rows.end(), word), std::sregex_iterator());
  };
  EXPECT_EQ(count("unstable"), 0) << rows;
  EXPECT_GE(count("stable"), 8) << rows;
}

// Explicit elements of the bars bear 2.5e-6 s, those of the plates 3e-7 s.
INSTANTIATE_TEST_SUITE_P(
    Scenes, ReducedBodiesAreStable,
    testing::Values(ReducedScene{"bars",
                                 with_key(with_protocol(config_text("two_bars"), "belytschko_mullen"), "partition",
                                          "reduced_modes", "{ left = 10, right = 9 }"),
                                 "2e-7:2e-4:5:log"},
                    ReducedScene{"plates", plates_of_modes, "1e-7:3e-6:4:log"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace ricochet::test
