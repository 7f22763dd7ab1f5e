// Scenes whose contacts have friction coefficients of their own: blocks that are stacked, and one in a corner.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <sstream>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

/// Three blocks on a floor, pressed together by p = 1 MPa from the start on, periodic across, of nu = 0, so that normal
/// motion and shear are apart: c_L = 1000 m/s, c_S = 707 m/s. The middle one flies along the others at 5 m/s, of solids
/// at 30 degrees to t.
struct Stack {
  bool solid = false;
  std::string law = "";  ///< further keys of the first contact
  double of_floor = 0.6, of_lower = 0.2, of_upper = 0.1;

  static constexpr double pressure_pa = 1e6, edge_m = 0.01, length_m = 0.1;
  static constexpr double speed_m_s = 5.0, shear_wave_s = 0.1 / 707.10678;
  [[nodiscard]] double force_n() const { return pressure_pa * edge_m * (solid ? edge_m : 1.0); }

  [[nodiscard]] std::string text(const std::string& protocol) const {
    std::string text = fmt::format("model = \"{}\"\n", solid ? "solid" : "plane_strain");
    const auto vector = [&](double along_t, double along_b, double axial) {
      return solid ? fmt::format("[{}, {}, {}]", along_t, along_b, axial) : fmt::format("[{}, {}]", along_t, axial);
    };
    for (int i = 0; i < 3; ++i) {
      const double shortened_m = pressure_pa / 1e9 * length_m, turn = solid ? M_PI / 6.0 : 0.0;
      const double speed = i == 1 ? speed_m_s : 0.0;
      text +=
          fmt::format(R"([[body]]
name = "{}"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.0, density_kg_m3 = 1000.0 }}
mesh = {{ start_m = {}, length_m = 0.1, height_m = 0.01, {}, periodic_across = true }}
initial_velocity_m_s = {}
initial_displacement_m = {{ start = {}, end = {} }}
)",
                      "abc"[i], length_m * i, solid ? "width_m = 0.01, elements = [3, 3, 20]" : "elements = [3, 20]",
                      vector(speed * std::cos(turn), speed * std::sin(turn), 0.0), vector(0, 0, -i * shortened_m),
                      vector(0, 0, -(i + 1) * shortened_m));
    }
    text += fmt::format("traction = [{{ surface = \"end\", traction_pa = {} }}]\n", vector(0, 0, -pressure_pa));
    const std::string further = law.empty() ? "" : law + "\n";
    text += fmt::format(
        "[[contact]]\nname = \"floor\"\nsurfaces = [\"a.start\", \"rigid_plane\"]\n"
        "friction_coefficient = {}\n{}",
        of_floor, further);
    text += fmt::format(
        "[[contact]]\nname = \"lower\"\nsurfaces = [\"a.end\", \"b.start\"]\n"
        "friction_coefficient = {}\n[[contact]]\nname = \"upper\"\nsurfaces = [\"b.end\", "
        "\"c.start\"]\nfriction_coefficient = {}\n",
        of_lower, of_upper);
    return text + fmt::format(
                      "[partition]\nimplicit_length_m = {{ a = 0.01, b = 0.01, c = 0.01 }}\n[time]\nsafety_factor = "
                      "0.9\nend_s = 4e-4\n[coupling]\nprotocol = \"{}\"\n",
                      protocol);
  }
};

/// |friction force| of a contact over its mean contact force.
double friction_ratio(const RunResult& r, const std::string& contact, double begin_s, double end_s) {
  const double along_t = r.mean("friction_force_n/" + contact, begin_s, end_s);
  const bool solid = r.history.count("friction_force_b_n/" + contact) > 0;
  const double along_b = solid ? r.mean("friction_force_b_n/" + contact, begin_s, end_s) : 0.0;
  return std::hypot(along_t, along_b) / r.mean("contact_force_n/" + contact, begin_s, end_s);
}

/// By hand: the middle block slips along both, with mu p A of each. The traction of the lower one runs down as a shear
/// wave, and the floor, which holds, gives it back: twice that traction from L/c_S to 3 L/c_S, nothing before. (A
/// penalty has to be pressed together first, and rings by some percent.)
void expect_own_friction(const Stack& stack, const RunResult& r, double tolerance = 2e-3) {
  const double force = stack.force_n(), half_s = stack.shear_wave_s;
  for (const char* contact : {"floor", "lower", "upper"}) {
    const std::string of = std::string("/") + contact;
    EXPECT_NEAR(r.mean("contact_force_n" + of, 2e-5, 4e-4), force, tolerance * force) << contact;
    EXPECT_EQ(r.last("pairs_open" + of), 0.0) << contact;
  }
  EXPECT_NEAR(friction_ratio(r, "lower", 2e-5, 4e-4), stack.of_lower, 1e-6);
  EXPECT_NEAR(friction_ratio(r, "upper", 2e-5, 4e-4), stack.of_upper, 1e-6);
  EXPECT_LT(friction_ratio(r, "floor", 0.0, 0.7 * half_s), 0.01 * stack.of_lower);
  EXPECT_NEAR(friction_ratio(r, "floor", 1.3 * half_s, 4e-4), 2.0 * stack.of_lower, 0.05 * stack.of_lower);
  EXPECT_EQ(r.last("pairs_slip/floor"), 0.0);
  EXPECT_EQ(r.last("pairs_stick/lower") + r.last("pairs_stick/upper"), 0.0);
  EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
}

/// In every row: no contact has more friction than its own mu lets it, and the sums are those of the three.
void expect_sums_and_cones(const Stack& stack, const RunResult& r) {
  const auto columns = [&](const std::string& quantity) {
    return std::array{&r.column(quantity + "/floor"), &r.column(quantity + "/lower"), &r.column(quantity + "/upper")};
  };
  const double mu[] = {stack.of_floor, stack.of_lower, stack.of_upper};
  for (const char* quantity : {"contact_force_n", "friction_force_n", "contact_impulse_n_s", "friction_impulse_n_s",
                               "pairs_stick", "pairs_slip", "pairs_open"}) {
    const auto of = columns(quantity);
    const auto& sum = r.column(quantity);
    for (std::size_t i = 0; i < sum.size(); ++i)
      ASSERT_NEAR((*of[0])[i] + (*of[1])[i] + (*of[2])[i], sum[i], 1e-12 * stack.force_n()) << quantity << " " << i;
  }
  const auto normal = columns("contact_force_n"), along_t = columns("friction_force_n");
  for (std::size_t i = 0; i < normal[0]->size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double along_b = stack.solid ? (*columns("friction_force_b_n")[c])[i] : 0.0;
      ASSERT_LE(std::hypot((*along_t[c])[i], along_b), mu[c] * (*normal[c])[i] + 1e-9 * stack.force_n()) << i;
    }
  }
}

class StackedBlocks : public testing::TestWithParam<const char*> {};

TEST_P(StackedBlocks, HaveTheFrictionOfEachContact) {
  const TemporaryFolder folder;
  const Stack stack;
  const RunResult r = run_text(stack.text(GetParam()), folder);
  expect_own_friction(stack, r);
  expect_sums_and_cones(stack, r);
}

/// Without friction at one of them that one transmits none, the others theirs.
TEST_P(StackedBlocks, MayHaveAContactWithoutFriction) {
  const TemporaryFolder folder;
  const Stack stack{.of_upper = 0.0};
  const RunResult r = run_text(stack.text(GetParam()), folder);
  expect_own_friction(stack, r);
  EXPECT_EQ(r.smallest("friction_force_n/upper"), 0.0);
  EXPECT_EQ(r.largest("friction_force_n/upper"), 0.0);
}

TEST_P(StackedBlocks, OfSolidsHaveItAlongTheirSlip) {
  const TemporaryFolder folder;
  const Stack stack{.solid = true};
  const RunResult r = run_text(stack.text(GetParam()), folder);
  expect_own_friction(stack, r);
  expect_sums_and_cones(stack, r);
  for (const char* contact : {"lower", "upper"}) {
    const std::string of = std::string("/") + contact;
    const double along_t = r.last("friction_impulse_n_s" + of), along_b = r.last("friction_impulse_b_n_s" + of);
    EXPECT_NEAR(std::abs(along_b / along_t), std::tan(M_PI / 6.0), 1e-6) << contact;
    EXPECT_EQ(r.summary.at("contacts").at(contact).at("friction_impulse_b_n_s").get<double>(), along_b);
  }
  EXPECT_EQ(r.summary.count("friction_impulse_b_n_s"), 0U) << "forces in series are not added";
  EXPECT_NE(r.last("friction_impulse_b_n_s"), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Protocols, StackedBlocks,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

TEST(StackedBlocksOfEachLaw, HaveTheFrictionOfEachContact) {
  for (const char* law : {"multiplier_update = \"massless\"", "multiplier_update = \"fully_implicit\"",
                          "enforcement = \"penalty\"\npenalty_pa_m = 1e12",
                          "enforcement = \"penalty\"\npenalty_pa_m = 1e12\nimpact_update = \"mass\""}) {
    for (const bool solid : {false, true}) {
      SCOPED_TRACE(fmt::format("{} {}", law, solid));
      const TemporaryFolder folder;
      const Stack stack{.solid = solid, .law = law};
      expect_own_friction(stack, run_text(stack.text("hughes_liu"), folder), 1e-2);
    }
  }
}

/// tanh(xi v) of 5 m/s and xi = 1 s/m is 0.9999, of the upper one less: the blocks move along. Nothing sticks.
TEST(StackedBlocksOfEachLaw, HaveTheRegularisedFrictionOfEachContact) {
  for (const bool solid : {false, true}) {
    const TemporaryFolder folder;
    const Stack stack{.solid = solid, .law = "friction_law = \"regularised\""};
    for (const char* protocol : {"hughes_liu", "all_explicit"}) {
      const RunResult r = run_text(stack.text(protocol), folder);
      EXPECT_NEAR(friction_ratio(r, "lower", 2e-5, 1e-4), 0.2, 1e-3) << protocol << solid;
      EXPECT_NEAR(friction_ratio(r, "upper", 2e-5, 1e-4), 0.1, 1e-3) << protocol << solid;
    }
  }
}

/// A block of 10 kg that flies into the corner of a floor and a wall at (1, -2) m/s: the node there has the normal of
/// one as the tangent of the other.
std::string corner(const std::string& protocol, double of_floor, double of_wall) {
  return fmt::format(R"(model = "plane_strain"
[[body]]
name = "block"
material = {{ youngs_modulus_pa = 1e9, poisson_ratio = 0.0, density_kg_m3 = 1000.0 }}
mesh = {{ length_m = 0.1, height_m = 0.1, elements = [8, 8] }}
initial_velocity_m_s = [1.0, -2.0]
[[contact]]
name = "floor"
surfaces = ["block.start", "rigid_plane"]
friction_coefficient = {}
[[contact]]
name = "wall"
surfaces = ["block.outer", "rigid_plane"]
friction_coefficient = {}
[partition]
implicit_length_m = {{ block = 0.03 }}
[time]
safety_factor = 0.9
end_s = 3e-4
[coupling]
protocol = "{}"
)",
                     of_floor, of_wall, protocol);
}

class Corner : public testing::TestWithParam<const char*> {};

/// The floor's n is -y and its t is x, the wall's are x and y.
TEST_P(Corner, GivesTheBlockTheImpulsesOfFloorAndWall) {
  for (const auto& [of_floor, of_wall] :
       {std::pair{0.3, 0.1}, {0.3, 0.3}, {0.2, 0.3}, {0.3, 0.2}, {0.0, 0.2}, {0.0, 0.0}}) {
    SCOPED_TRACE(fmt::format("{} {}", of_floor, of_wall));
    const TemporaryFolder folder;
    const RunResult r = run_text(corner(GetParam(), of_floor, of_wall), folder);
    EXPECT_NEAR(r.last("momentum_n_kg_m_s"),
                20.0 - r.last("contact_impulse_n_s/floor") + r.last("friction_impulse_n_s/wall"), 1e-9);
    EXPECT_NEAR(r.last("momentum_t_kg_m_s"),
                10.0 - r.last("contact_impulse_n_s/wall") - r.last("friction_impulse_n_s/floor"), 1e-9);
    for (const auto& [contact, mu] : {std::pair{"floor", of_floor}, {"wall", of_wall}}) {
      const std::string of = std::string("/") + contact;
      EXPECT_LE(std::abs(r.last("friction_impulse_n_s" + of)), mu * r.last("contact_impulse_n_s" + of) * (1 + 1e-9));
      EXPECT_EQ(r.last("friction_impulse_n_s" + of) != 0.0, mu > 0.0);
    }
    EXPECT_EQ(r.last("energy_friction_j") > 0.1, of_floor + of_wall > 0.0);
    if (of_floor + of_wall == 0.0) {
      EXPECT_EQ(r.last("energy_friction_j"), 0.0);
    }
    EXPECT_LT(r.summary.at("momentum_error_max").get<double>(), 1e-10);
    EXPECT_LT(r.last("energy_error"), 1e-12) << "no energy is made";
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, Corner,
                         testing::Values("hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"),
                         [](const auto& test) { return std::string(test.param); });

/// A study varies the coefficient of one contact by its name, and measures that one.
TEST(StudyOfAContact, MeasuresItByName) {
  const TemporaryFolder folder;
  (void)folder.write(Stack().text("hughes_liu"), "stack.toml");
  const std::string out = (folder.path() / "study").string();
  const auto path = folder.write(R"(scene = "stack.toml"
methods = ["hughes_liu"]
quantities = ["friction_force", "friction_force/lower", "friction_force/upper", "peak_force/upper"]
along = "contact.upper.friction_coefficient"
[[vary]]
contact.upper.friction_coefficient = [0.1, 0.15]
[reference]
protocol = "hughes_liu"
refine = { time.safety_factor = 0.45 }
[histories]
quantity = "contact_pressure/upper"
over_pa = 1e6
over_name = "p"
compare_to = "hughes_liu"
)",
                                 "study.toml");
  const auto outcome = run_command({ricochet_binary(), "study", path, "--out", out}, folder.path().string(), 300.0);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  std::istringstream lines(file_text(out + "/results.csv"));
  std::string header, same, other;
  std::getline(lines, header);
  std::getline(lines, same);
  std::getline(lines, other);
  EXPECT_THAT(header, testing::StartsWith("method,contact.upper.friction_coefficient,status,error_friction_force,error_"
                                          "friction_force/lower,error_friction_force/upper,error_peak_force/upper,"));
  EXPECT_THAT(same, testing::StartsWith("hughes_liu,0.1,done,0,0,0,0,"));
  // RMS over the plateau of the contact force: |0.15 - 0.1| p A of p A.
  std::vector<std::string> cells;
  std::istringstream row(other);
  for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
  ASSERT_GT(cells.size(), 6U) << other;
  EXPECT_NEAR(std::stod(cells[5]), 0.05, 1e-3);
  EXPECT_NEAR(std::stod(cells[3]), 0.05 / 3.0, 1e-3) << "of three contacts with p A each";
  EXPECT_LT(std::stod(cells[4]), 1e-6) << "that of the other contact is the same";
  const auto page = file_text(out + "/report.html");
  for (const char* chart : {"along_error_friction_force_2fupper_1", "friction_force_2fupper_wall_s"})
    EXPECT_THAT(page, testing::HasSubstr(fmt::format("id=\"{}\"", chart)));
  EXPECT_THAT(page, testing::HasSubstr("Error of the friction force at upper"));
  EXPECT_THAT(page, testing::HasSubstr("mean contact pressure at upper over p"));
}

/// The report of a run draws each of several contacts, and says when and how strongly each was there.
TEST(ReportOfContacts, DrawsEachOfThem) {
  const TemporaryFolder folder;
  const RunResult r = run_text(Stack().text("all_explicit"), folder);
  const auto page = file_text(r.folder + "/report.html");
  for (const char* label : {"at floor", "at lower", "at upper"}) EXPECT_THAT(page, testing::HasSubstr(label));
  EXPECT_THAT(page, testing::HasSubstr("contact upper"));
}

}  // namespace
}  // namespace ricochet::test
