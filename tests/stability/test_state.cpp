// The state of a window's boundary is all that the next window depends on: windows in a row, and windows between which
// the state is read and loaded, lead to the same. With the solvers themselves, in this process.
#include <gtest/gtest.h>

#include "coupler/spectrum/window_map.hpp"
#include "tests/support/one_process.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// A scene with all its participants in this process.
class InOneProcess {
 public:
  explicit InOneProcess(const std::string& text) : run_(folder_.write(text)) {}
  [[nodiscard]] coupler::LinearMap map(const std::string& contact) {
    return coupler::window_map(run_.coupling(), run_.protocol(), *find_named<FrozenContact>(contact));
  }

 private:
  TemporaryFolder folder_;
  OneProcess run_;
};

/// Plates of two bodies with friction, gravity, a load, a support and a moving support, of which nothing may be left.
std::string plates(const std::string& protocol, const std::string& contact) {
  return R"(model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 2e11, poisson_ratio = 0.3, density_kg_m3 = 8000.0 }
thickness_m = 0.01
mesh = { start_m = -0.04, length_m = 0.04, height_m = 0.02, elements = [2, 4] }
gravity_m_s2 = [0.0, -9.81]
support = [{ surface = "start", fixed = ["y"] }]
prescribed = [{ surface = "start", component = "x", displacement_m = 1e-5 }]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 7e10, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }
thickness_m = 0.01
mesh = { length_m = 0.04, height_m = 0.02, elements = [2, 4] }
initial_velocity_m_s = [1.0, -2.0]
traction = [{ surface = "end", traction_pa = [0.0, -1e6] }]
[contact]
surfaces = ["lower.end", "upper.start"]
initial_gap_m = 1e-4
)" + contact +
         R"(
[partition]
implicit_length_m = { lower = 0.02, upper = 0.01 }
[time]
step_s = 1.0e-6
end_s = 1e-3
[coupling]
resynchronise_every = 3
protocol = ")" +
         protocol + "\"\n";
}

struct Law {
  std::string name, contact;
};

class State : public testing::TestWithParam<std::tuple<std::string, Law, std::string>> {};

TEST_P(State, IsAllThatTheNextWindowDependsOn) {
  const auto& [protocol, law, frozen] = GetParam();
  InOneProcess run(plates(protocol, law.contact));
  const auto map = run.map(frozen);
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(map.size, 0.0, 100.0).array().sin(), in_a_row, one_by_one, again;
  map.load(x);
  map.advance(2);  // onto the states that the scheme itself brings about: a held contact, forces made by the motion
  map.read(x);
  map.load(x);
  map.read(again);
  EXPECT_LT((again - x).norm(), 1e-13 * x.norm()) << "loading changes nothing then";
  map.load(x);
  map.advance(6);
  map.read(in_a_row);
  one_by_one = x;
  for (int n = 0; n < 6; ++n) {
    map.load(one_by_one);
    map.advance(1);
    map.read(one_by_one);
  }
  EXPECT_GT((in_a_row - x).norm(), 1e-2 * x.norm()) << "something happens at all";
  EXPECT_LT((in_a_row - one_by_one).norm(), 1e-11 * in_a_row.norm());
}

TEST_P(State, ZeroStaysZeroWithoutLoads) {
  const auto& [protocol, law, frozen] = GetParam();
  InOneProcess run(plates(protocol, law.contact));
  const auto map = run.map(frozen);
  Eigen::VectorXd x;
  map.load(Eigen::VectorXd::Zero(map.size));
  map.advance(5);
  map.read(x);
  EXPECT_EQ(x.norm(), 0.0);
}

const std::string friction = "friction_coefficient = 0.2\n";
const std::string penalty = "enforcement = \"penalty\"\npenalty_pa_m = 1e13\n";
std::string name_of(const testing::TestParamInfo<State::ParamType>& test) {
  return std::string(std::get<0>(test.param)) + "_" + std::get<1>(test.param).name + "_" + std::get<2>(test.param);
}

INSTANTIATE_TEST_SUITE_P(
    All, State,
    testing::Combine(testing::Values("hughes_liu", "kim", "kim_predicted", "all_implicit", "belytschko_mullen",
                                     "prakash_hjelmstad", "gravouil_combescure"),
                     testing::Values(Law{"reset", friction}, Law{"frictionless", ""},
                                     Law{"fully_implicit", friction + "multiplier_update = \"fully_implicit\""},
                                     Law{"penalty", friction + penalty},
                                     Law{"impedance", friction + penalty + "impact_update = \"impedance\""},
                                     Law{"regularised", friction + "friction_law = \"regularised\""}),
                     testing::Values("open", "sticking")),
    name_of);
INSTANTIATE_TEST_SUITE_P(AllExplicit, State,
                         testing::Combine(testing::Values("all_explicit"),
                                          testing::Values(Law{"reset", friction}, Law{"frictionless", ""},
                                                          Law{"penalty", friction + penalty},
                                                          Law{"regularised",
                                                              friction + "friction_law = \"regularised\""}),
                                          testing::Values("open", "sticking")),
                         name_of);

}  // namespace
}  // namespace ricochet::test
