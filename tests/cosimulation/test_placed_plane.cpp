#include <gmock/gmock.h>

#include "tests/support/block_mesh.hpp"
#include "tests/support/run.hpp"

// A rigid plane with a place and a normal of its own.

namespace ricochet::test {
namespace {

using testing::HasSubstr;

constexpr BlockMesh block{0.01, 0.0, 0.01, 3, 3, true};
constexpr Turn askew{0.4, 0.3}, whole{0.7, -1.1};

std::string list_of(const Vector3& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v[0], v[1], v[2]); }

/// A block that flies against a plane; mesh, velocity, place and normal turned together.
std::string flying_block(const Turn& turn, const std::string& protocol, const std::string& more = "") {
  return "model = \"solid\"\n[[body]]\nname = \"block\"\nmaterial = { youngs_modulus_pa = 2e11, poisson_ratio = 0.3, "
         "density_kg_m3 = 8000.0 }\nmesh = { gmsh = \"block.msh\" }\ninitial_velocity_m_s = " +
         list_of(turn.of({0.0, 0.0, -2.0})) +
         "\n[contact]\nsurfaces = [\"block.start\", \"rigid_plane\"]\nrigid_place_m = " +
         list_of(turn.of({0.3, -0.2, -2.13e-5})) + "\nnormal = " + list_of(turn.of({0.0, 0.0, -1.0})) + "\n" + more +
         "[time]\nstep_s = 1e-7\nend_s = 6e-5\n[output]\nhistory_every = 5\n[coupling]\nprotocol = \"" + protocol +
         "\"\n";
}

void expect_same_forces(const RunResult& a, const RunResult& b) {
  const auto &x = a.column("contact_force_n"), &y = b.column("contact_force_n");
  ASSERT_EQ(x.size(), y.size());
  ASSERT_GT(b.largest("contact_force_n"), 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(x[i], y[i], 1e-9 * b.largest("contact_force_n")) << i;
}

/// A block askew to the plane, which a corner meets first: the whole scene turned has the same forces.
TEST(PlacedPlane, PressesASceneThatIsTurnedAsBefore) {
  for (const std::string protocol : {"all_explicit", "hughes_liu"}) {
    const TemporaryFolder folder;
    const std::string mesh = turned(block_msh("block", block), askew);
    (void)folder.write(mesh, "block.msh");
    const RunResult upright = run_text(flying_block({}, protocol), folder, "upright");
    (void)folder.write(turned(mesh, whole), "block.msh");
    const RunResult inclined = run_text(flying_block(whole, protocol), folder, "inclined");
    expect_same_forces(inclined, upright);
    EXPECT_LT(inclined.summary.at("momentum_error_max").get<double>(), 1e-10) << protocol;
  }
}

std::string disc(const char* model, const std::string& extent, const std::string& contact) {
  return std::string("model = \"") + model +
         "\"\n[[body]]\nname = \"disc\"\nmaterial = \"steel_a36\"\nmesh = { length_m = 0.01, " + extent +
         ", elements = [4, 8] }\ninitial_velocity_m_s = [0.0, -5.0]\n[contact]\nsurfaces = [\"disc.start\", "
         "\"rigid_plane\"]\n" +
         contact + "[time]\nstep_s = 1e-7\nend_s = 3e-5\n[coupling]\nprotocol = \"all_implicit\"\n";
}

/// Across the axis it is the plane that the gap places.
TEST(PlacedPlane, AcrossTheAxisIsThePlaneOfAGap) {
  for (const auto& [model, extent] :
       {std::pair{"axisymmetric", "radius_m = 0.01"}, {"plane_strain", "height_m = 0.01"}}) {
    const TemporaryFolder folder;
    const RunResult placed =
        run_text(disc(model, extent, "rigid_place_m = [0.5, -1e-5]\nnormal = [0.0, -1.0]\n"), folder, "placed");
    const RunResult gap = run_text(disc(model, extent, "initial_gap_m = 1e-5\n"), folder, "gap");
    expect_same_forces(placed, gap);
  }
}

/// Without friction only the part of the momentum along an inclined plane's normal changes.
TEST(PlacedPlane, TurnsABlockAsideAlongItsNormal) {
  const TemporaryFolder folder;
  const RunResult run = run_text(
      disc("plane_strain", "height_m = 0.01", "rigid_place_m = [0.0, -1e-5]\nnormal = [-0.5, -0.8660254037844386]\n"),
      folder);
  EXPECT_GT(run.last("contact_impulse_n_s"), 0.0);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
  const auto& along = run.column("momentum_t_kg_m_s");
  EXPECT_NEAR(along.back(), along.front(), 1e-9 * std::abs(along.front()));
}

struct Wrong {
  const char* name;
  const char* model;
  const char* contact;
  const char* error;
};

class WrongPlacedPlane : public testing::TestWithParam<Wrong> {};

TEST_P(WrongPlacedPlane, IsRefused) {
  const TemporaryFolder folder;
  const bool round = std::string(GetParam().model) == "axisymmetric";
  const std::string scene =
      folder.write(disc(GetParam().model, round ? "radius_m = 0.01" : "height_m = 0.01", GetParam().contact));
  const Outcome outcome = run_command({ricochet_binary(), "check", scene}, folder.path().string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.error, HasSubstr(GetParam().error));
}

INSTANTIATE_TEST_SUITE_P(
    All, WrongPlacedPlane,
    testing::Values(
        Wrong{"NoNormal", "plane_strain", "rigid_place_m = [0.0, -1e-5]\n", "contact.normal"},
        Wrong{"IntoTheBody", "plane_strain", "rigid_place_m = [0.0, -1e-5]\nnormal = [0.0, 1.0]\n",
              "a normal into surface \"disc.start\""},
        Wrong{"WithoutLength", "plane_strain", "rigid_place_m = [0.0, -1e-5]\nnormal = [0.0, 0.0]\n",
              "a direction without length"},
        Wrong{"BehindNodes", "plane_strain", "rigid_place_m = [0.0, 1e-3]\nnormal = [0.0, -1.0]\n",
              "a node of \"disc.start\" 0.001 m behind the rigid plane"},
        Wrong{"Cone", "axisymmetric", "rigid_place_m = [0.0, -1e-5]\nnormal = [0.6, -0.8]\n", "would be a cone"},
        Wrong{"WithAGap", "plane_strain", "rigid_place_m = [0.0, -1e-5]\nnormal = [0.0, -1.0]\ninitial_gap_m = 1e-5\n",
              "only with a plane without rigid_place_m"},
        Wrong{"WithANose", "plane_strain", "rigid_place_m = [0.0, -1e-5]\nnormal = [0.0, -1.0]\nnose_radius_m = 1.0\n",
              "only with a plane without rigid_place_m"}),
    [](const auto& wrong) { return std::string(wrong.param.name); });

}  // namespace
}  // namespace ricochet::test
