#include <gtest/gtest.h>

#include <cmath>

#include "coupler/results/theory.hpp"
#include "tests/support/places.hpp"

namespace ricochet::coupler {
namespace {

const std::string configs = test::source_folder() + "/configs/";

std::optional<ImpactTheory> theory_of(const std::string& file) {
  return impact_theory(scene::build_problem(scene::load_scene(configs + file)));
}

TEST(ImpactTheory, PaperScene) {
  const auto theory = theory_of("kim_impact.toml");
  ASSERT_TRUE(theory);
  EXPECT_NEAR(theory->stress_pa, 853.8e6, 0.1e6);
  EXPECT_NEAR(theory->contact_duration_s, 31.18e-6, 0.01e-6);
  EXPECT_EQ(theory->body, "steel");
}

TEST(ImpactTheory, EqualBarsOfCarpenter) {
  const auto theory = theory_of("two_bars.toml");
  ASSERT_TRUE(theory);
  EXPECT_NEAR(theory->stress_pa * 6.4516e-4, 1.33453e5, 5.0);
  EXPECT_NEAR(theory->contact_duration_s, 148.393e-6 - 49.456e-6, 2e-9);
}

// The wave of an absorbing body does not come back: it ends no contact, and of the body that would, there is no theory.
TEST(ImpactTheory, KnowsThatAnAbsorbingSurfaceReturnsNothing) {
  const auto theory_with = [](const char* config, const std::string& absorbing) {
    auto scene = scene::load_scene(configs + config);
    for (auto& body : scene.bodies)
      if (body.name == absorbing) body.absorbing.push_back({body.name == "left" ? "start" : "end", scene::Wave::bar});
    return impact_theory(scene::build_problem(scene));
  };
  EXPECT_FALSE(theory_with("unequal_bars.toml", "bar")) << "of lower impedance than the striker";
  const auto equal = theory_with("two_bars.toml", "right"), whole = theory_with("two_bars.toml", "none");
  ASSERT_TRUE(equal && whole);
  EXPECT_EQ(equal->contact_duration_s, whole->contact_duration_s);
  EXPECT_EQ(equal->body, "left");
  EXPECT_TRUE(equal->other_body_returns_later);
}

TEST(ImpactTheory, TheFirstStepEndsWithTheFirstWaveThatIsBack) {
  const auto paper = theory_of("kim_impact.toml");
  ASSERT_TRUE(paper);
  EXPECT_NEAR(paper->first_step_s, 2 * 0.08 / std::sqrt(626.8e9 / 14900.0), 1e-9)
      << "of the carbide, before the steel's";
  const auto equal = theory_of("two_bars.toml");
  ASSERT_TRUE(equal);
  EXPECT_EQ(equal->first_step_s, equal->contact_duration_s);
}

TEST(ImpactTheory, NoneForABodyThatDoesMoreThanFly) {
  const auto theory_with = [](const auto& change) {
    auto scene = scene::load_scene(configs + "two_bars.toml");
    change(scene);
    return impact_theory(scene::build_problem(scene)).has_value();
  };
  EXPECT_TRUE(theory_with([](scene::Scene&) {}));
  EXPECT_FALSE(theory_with([](scene::Scene& s) {
    s.bodies[1].initial_velocity_m_s = {0.0};
    s.bodies[1].supports.push_back({"end", {0}});
  }));
  EXPECT_FALSE(theory_with([](scene::Scene& s) {
    s.bodies[1].initial_velocity_m_s = {0.0};
    s.bodies[1].prescribed.push_back({"end", 0, 1e-3, {}, {}});
  }));
  EXPECT_FALSE(theory_with([](scene::Scene& s) { s.bodies[0].gravity_m_s2 = {9.81}; }));
  EXPECT_FALSE(theory_with([](scene::Scene& s) { s.bodies[0].tractions.push_back({"start", {1e6}, {}}); }));
  EXPECT_FALSE(theory_with([](scene::Scene& s) { s.bodies[0].initial_displacement_end_m = {-1e-5}; }));
  EXPECT_FALSE(theory_of("rounded_striker.toml")) << "a nose";
  EXPECT_FALSE(theory_of("two_balls.toml")) << "curved surfaces";
}

TEST(ImpactTheory, NoneWithARigidPlane) { EXPECT_FALSE(theory_of("rod_on_stop.toml")); }

}  // namespace
}  // namespace ricochet::coupler
