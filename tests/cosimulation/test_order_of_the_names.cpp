// The program chooses which of two surfaces carries the rows of a contact: the order of their names changes no force,
// and columns keep the directions of the surface that is named first.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/dome_mesh.hpp"
#include "tests/support/plane_grid.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

std::string body_of(const std::string& name, const std::string& velocity) {
  return fmt::format(
      "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 "
      "}}\nmesh = {{ gmsh = \"{0}.msh\" }}\ninitial_velocity_m_s = {1}\n",
      name, velocity);
}

/// Both orders of the names, `rest` of the scene after the contact's surfaces; `normals` of either first surface.
std::pair<RunResult, RunResult> in_both_orders(const std::string& bodies, const std::vector<std::string>& normals,
                                               const std::string& rest, const TemporaryFolder& folder) {
  const auto run = [&](const char* first, const char* second, const std::string& normal, const char* name) {
    return run_text(bodies +
                        fmt::format("[contact]\nsurfaces = [\"{}.cap\", \"{}.cap\"]\n{}\n", first, second, normal) +
                        "friction_coefficient = 0.2\ninitial_gap_m = 1e-5\n" + rest,
                    folder, name);
  };
  return {run("lower", "upper", normals[0], "one"), run("upper", "lower", normals[1], "other")};
}

/// `other` has the column of `one`, times `sign`.
void expect_same(const RunResult& one, const RunResult& other, const std::string& column, double sign) {
  const auto &x = one.column(column), &y = other.column(column);
  ASSERT_EQ(x.size(), y.size());
  const double most = std::max(one.largest(column), -one.smallest(column));
  EXPECT_GT(most, 0.0) << column;
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_NEAR(y[i], sign * x[i], 1e-9 * most) << column << " " << i;
}

/// In the plane t turns round with n: what acts on the second body along it stays, and momentum changes its sign.
TEST(OrderOfTheNames, ChangesNoForceInThePlane) {
  for (const char* protocol : {"hughes_liu", "all_implicit", "all_explicit"}) {
    const TemporaryFolder folder;
    (void)folder.write(disc_msh("lower", 0.0, -0.01, 0.01, 14, true), "lower.msh");
    (void)folder.write(disc_msh("upper", 0.0, 0.01, 0.01, 18, false), "upper.msh");
    const auto [one, other] = in_both_orders(
        "model = \"plane_strain\"\n" + body_of("lower", "[4.0, 10.0]") + body_of("upper", "[-4.0, -10.0]"), {"", ""},
        fmt::format("[time]\nstep_s = 5e-8\nend_s = 4e-5\n[output]\nhistory_every = 1\n[coupling]\nprotocol = \"{}\"\n",
                    protocol) +
            (std::string(protocol) == "hughes_liu" ? "[partition]\nimplicit_length_m = { lower = 2e-3, upper = 2e-3 }\n"
                                                   : ""),
        folder);
    EXPECT_GT(one.largest("contact_force_n"), 1e5) << protocol;
    for (const char* column : {"contact_force_n", "friction_force_n", "normal_force_t_n", "energy_friction_j"})
      expect_same(one, other, column, 1.0);
    expect_same(one, other, "momentum_t_kg_m_s", -1.0);
  }
}

/// For solids whose normal is along z the tangent x stays, and what acts along it on the second body turns round.
TEST(OrderOfTheNames, ChangesNoForceOfSolids) {
  const TemporaryFolder folder;
  for (const bool lower : {true, false}) {
    const std::string name = lower ? "lower" : "upper";
    (void)folder.write(dome_msh(name, {.radius_m = 0.1,
                                       .start_m = lower ? -0.004 : 0.0,
                                       .up = lower,
                                       .half_x = false,
                                       .half_y = false,
                                       .across = lower ? 3 : 4,
                                       .along = 3}),
                       name + ".msh");
  }
  const auto [one, other] = in_both_orders(
      "model = \"solid\"\n" + body_of("lower", "[1.0, 0.4, 2.0]") + body_of("upper", "[-1.0, -0.4, -2.0]"),
      {"normal = [0.0, 0.0, 1.0]", "normal = [0.0, 0.0, -1.0]"},
      "[time]\nstep_s = 1e-7\nend_s = 2e-5\n[output]\nhistory_every = 1\n[coupling]\nprotocol = \"all_explicit\"\n",
      folder);
  expect_same(one, other, "contact_force_n", 1.0);
  for (const char* column : {"friction_force_n", "friction_impulse_n_s", "normal_force_t_n"})
    expect_same(one, other, column, -1.0);
  for (const char* column : {"friction_force_b_n", "normal_force_b_n", "energy_friction_j"})
    expect_same(one, other, column, 1.0);
}

/// Blocks whose shortest edges are as long as each other, across the contact: the faces along it decide, not which body
/// comes first.
TEST(OrderOfTheBodies, ChangesNoForceOfAnEdgeOnABlockOfOtherFaces) {
  const TemporaryFolder folder;
  const std::string low = R"([[body]]
name = "low"
large_rotation = true
material = { youngs_modulus_pa = 70e9, poisson_ratio = 0.3, density_kg_m3 = 2700.0 }
mesh = { length_m = 0.006, height_m = 0.01, width_m = 0.01, elements = [5, 4, 4], place = { moved_m = [-0.005, -0.005, 0.0] } }
)",
                    high = R"([[body]]
name = "high"
large_rotation = true
material = { youngs_modulus_pa = 200e9, poisson_ratio = 0.0, density_kg_m3 = 2700.0 }
initial_velocity_m_s = [10.0, -3.0, -5.0]
initial_angular_velocity_rad_s = [100.0, 200.0, 50.0]
mesh = { length_m = 0.006, height_m = 0.01, width_m = 0.01, elements = [3, 2, 4], place = { turned_deg = [0.0, 5.0, 0.0], about_m = [0.005, 0.005, 0.0], moved_m = [-0.005, -0.005, 0.00644578] } }
)";
  const auto run = [&](const std::string& bodies, const std::string& surfaces, const char* normal, const char* name) {
    return run_text("model = \"solid\"\n" + bodies + "[contact]\nsurfaces = [" + surfaces + "]\nnormal = [0.0, 0.0, " +
                        normal +
                        "]\nfriction_coefficient = 0.3\n[coupling]\nprotocol = \"all_explicit\"\n[time]\nstep_s = "
                        "6e-8\nend_s = 1.2e-5\n",
                    folder, name);
  };
  const auto one = run(low + high, "\"high.outside\", \"low.outside\"", "-1.0", "one"),
             other = run(high + low, "\"low.outside\", \"high.outside\"", "1.0", "other");
  expect_same(one, other, "contact_force_n", 1.0);
}

}  // namespace
}  // namespace ricochet::test
