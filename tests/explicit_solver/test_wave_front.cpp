// The explicit solver leaves out rows that no wave has reached: the same bits as with all rows, and fewer of them.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "explicit_solver/explicit_solver.hpp"
#include "explicit_solver/wave_front.hpp"
#include "tests/support/all_rows.hpp"
#include "tests/support/places.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::explicit_solver {
namespace {

std::string config_text(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(test::source_folder() + "/configs/" + name + ".toml").rdbuf();
  return text.str();
}

const std::string all_explicit = "[coupling]\nprotocol = \"all_explicit\"\n";

scene::Problem problem_of(const std::string& text) {
  const test::TemporaryFolder folder;
  const std::string configs = test::source_folder() + "/configs/";
  std::string absolute = text;
  if (const auto at = absolute.find("gmsh = \""); at != std::string::npos) {
    for (std::size_t next = at; next != std::string::npos; next = absolute.find("gmsh = \"", next + 8 + configs.size()))
      absolute.insert(next + 8, configs);
  }
  return scene::build_problem(scene::load_scene(folder.write(absolute)));
}

bool same_bits(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

/// Rows of K u that a step computes at present.
int rows_computed(const ExplicitSolver& solver) {
  int sum = 0;
  const auto& stepping = solver.stepping();
  for (std::size_t part = 0; part < stepping.states().size(); ++part) {
    for (const auto& [first, last] : stepping.force(part).rows()) sum += last - first;
  }
  return sum;
}

/// Two solvers of one scene, one of which computes all rows.
class Twins {
 public:
  explicit Twins(const std::string& text, participant::Setup setup = {})
      : problem_(problem_of(text)), skipping(problem_, "explicit"), full(problem_, "explicit") {
    setup.clock = problem_.clock.size_s();
    setup.last_window = 1'000'000;
    setup.interface_mass_kg = full.describe().interface_mass_kg;
    each([&](ExplicitSolver& solver, participant::LinkOutput& output) { solver.initialize(setup, output); });
    test::compute_all_rows(full);
    synchronise(std::vector<double>(output_.value.size(), 0.0));
  }
  void synchronise(const std::vector<double>& link) {
    each([&](ExplicitSolver& solver, participant::LinkOutput& output) {
      solver.synchronise(participant::Integration::implicit_newmark, link, output);
    });
  }
  void step(const std::vector<double>& link) {
    ++window_;
    each([&](ExplicitSolver& solver, participant::LinkOutput& output) {
      solver.advance(window_, std::vector<double>(link.size(), 1e-7), output);  // a trial that is given up
      solver.advance(window_, link, output);
      solver.accept();
      solver.work_ahead();
    });
  }
  void step() { step({}); }
  void expect_same_bits() {
    const auto all = full.state().stepping.bodies, some = skipping.state().stepping.bodies;
    for (std::size_t b = 0; b < all.size(); ++b) {
      const auto &expected = all[b], &found = some[b];
      ASSERT_TRUE(same_bits(found.u, expected.u)) << "u, window " << window_;
      ASSERT_TRUE(same_bits(found.v, expected.v)) << "v, window " << window_;
      ASSERT_TRUE(found.a == expected.a) << "a, window " << window_;
    }
    std::vector<double> expected, found;
    full.record(expected);
    skipping.record(found);
    ASSERT_EQ(found, expected) << "window " << window_;
  }
  [[nodiscard]] double share() const { return 1.0 * rows_computed(skipping) / rows_computed(full); }
  [[nodiscard]] std::size_t link_size() const { return output_.value.size(); }

 private:
  template <class Call>
  void each(Call call) {
    participant::LinkOutput other;
    call(skipping, other);
    call(full, output_);
    ASSERT_EQ(other.value, output_.value) << "window " << window_;
  }
  scene::Problem problem_;

 public:
  ExplicitSolver skipping, full;

 private:
  participant::LinkOutput output_;
  std::int64_t window_ = 0;
};

struct Case {
  std::string name, text;
  int windows;
  double early;  ///< share of the rows computed after ten windows, at most
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const std::string loads = R"(model = "plane_strain"
[[body]]
name = "plate"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 1.0, height_m = 0.1, elements = [6, 60] }
initial_velocity_m_s = [3.0, 7.0]
)";
const std::string time_table = "[time]\nsafety_factor = 0.9\nend_s = 1.0\n" + all_explicit;

const Case cases[] = {
    // Flight and impact of axisymmetric bodies; waves through all of both.
    {"impact", config_text("kim_impact") + all_explicit, 700, 0.2},
    // 22 windows of flight before they meet; 21 nodes are three slices.
    {"bars_after_a_flight", config_text("two_bars") + all_explicit, 120, 0.7},
    {"gmsh", config_text("striker_gmsh") + all_explicit, 150, 0.9},
    {"plates_that_stick", config_text("sticking_plates") + all_explicit, 300, 0.2},
    {"stretched_from_the_start", test::replaced(config_text("rod_on_stop"), "[coupling]\n", all_explicit), 200, 1.0},
    {"traction",
     loads +
         "traction = [{ surface = \"outer\", traction_pa = [0.0, 0.0] }, { surface = \"end\", traction_pa = [1e5, "
         "2e5], "
         "amplitude = { time_s = [0.0, 1e-3], factor = [0.0, 1.0] } }]\n" +
         time_table,
     200, 0.3},
    {"prescribed",
     loads +
         "prescribed = [{ surface = \"start\", component = \"y\", displacement_m = 1e-3, "
         "amplitude = { time_s = [2e-4, 1e-3], factor = [0.0, 1.0] } }]\n" +
         time_table,
     200, 0.3},
    {"gravity", loads + "gravity_m_s2 = [0.0, -9.81]\n" + time_table, 20, 1.0},
    {"stopped_by_a_support", loads + "support = [{ surface = \"end\", fixed = [\"y\"] }]\n" + time_table, 200, 0.4},
    {"absorbing",
     loads +
         "support = [{ surface = \"end\", fixed = [\"y\"] }]\n"
         "absorbing = [{ surface = \"start\", wave = \"dilatational\" }]\n" +
         time_table,
     200, 0.4},
};

class SkippedRows : public testing::TestWithParam<Case> {};

TEST_P(SkippedRows, LeaveEveryBitAsItIs) {
  Twins twins(GetParam().text);
  for (int n = 1; n <= GetParam().windows; ++n) {
    twins.step();
    if (n == 10) {
      EXPECT_LE(twins.share(), GetParam().early);
    }
    if (n == 50) twins.synchronise({});
    if (n % 10 == 0 || n < 30) twins.expect_same_bits();
    if (testing::Test::HasFatalFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(AllExplicit, SkippedRows, testing::ValuesIn(cases),
                         [](const auto& test) { return test.param.name; });

/// Displacements of the shared nodes or forces on them: nothing at first.
std::vector<double> link_of(std::size_t size, int window, double scale) {
  std::vector<double> link(size, 0.0);
  for (std::size_t i = 0; i < size; ++i) {
    if (window > 15) link[i] = scale * std::sin(0.1 * (window - 15) + 0.3 * static_cast<double>(i));
  }
  return link;
}

TEST(SkippedRowsOfAHybrid, LeaveEveryBitAsItIs) {
  Twins twins(config_text("kim_impact"));
  for (int n = 1; n <= 400; ++n) {
    const auto link = link_of(twins.link_size(), n, 1e-6);
    twins.step(link);
    if (n == 10) {
      EXPECT_LE(twins.share(), 0.2);
    }
    if (n % 100 == 0) twins.synchronise(link);
    if (n % 10 == 0 || n < 30) twins.expect_same_bits();
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_EQ(twins.share(), 1.0) << "waves through both bodies";
}

TEST(SkippedRowsOfADualProtocol, LeaveEveryBitAsItIs) {
  participant::Setup setup;
  setup.driven_by = participant::Drive::force;
  setup.substeps = 3;
  const std::string text = test::replaced(config_text("kim_impact"), "step_s = 5.4e-8", "step_s = 1.62e-7") +
                           "[coupling]\nprotocol = \"prakash_hjelmstad\"\nsubsteps = 3\n";
  Twins twins(text, setup);
  for (int n = 1; n <= 150; ++n) {
    twins.step(link_of(twins.link_size(), n, 1e3));
    if (n == 3) {
      EXPECT_LE(twins.share(), 0.2);
    }
    if (n % 10 == 0 || n < 30) twins.expect_same_bits();
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_EQ(twins.share(), 1.0) << "waves through both bodies";
}

TEST(SkippedRows, AreNoneOfALoadedState) {
  for (const auto drive : {participant::Drive::displacement, participant::Drive::force}) {
    participant::Setup setup;
    setup.driven_by = drive;
    const bool dual = drive == participant::Drive::force;
    Twins twins(config_text("kim_impact") + (dual ? "[coupling]\nprotocol = \"prakash_hjelmstad\"\n" : ""), setup);
    std::vector<double> state, scale;
    twins.full.read_state(state, scale);
    for (std::size_t i = 0; i < state.size(); ++i) state[i] = std::sin(0.01 * static_cast<double>(i)) / scale[i];
    for (auto* solver : {&twins.full, &twins.skipping}) solver->load_state(state, participant::FrozenContact::open);
    EXPECT_EQ(twins.share(), 1.0);
    twins.synchronise(std::vector<double>(twins.link_size(), 0.0));
    for (int n = 1; n <= 20; ++n) {
      twins.step(link_of(twins.link_size(), n, dual ? 1e3 : 1e-6));
      twins.expect_same_bits();
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(WaveFront, GrowsByALayerOfElementsPerStep) {
  // 61 rows of 7 nodes. In ten steps the impulse of the traction is ten layers deep, and slices end with a row or two
  // more.
  Twins twins(cases[5].text);
  const double layers = 61.0;
  for (int n = 1; n <= 10; ++n) twins.step();
  EXPECT_GE(twins.share(), 8.0 / layers);
  EXPECT_LE(twins.share(), 16.0 / layers);
}

}  // namespace
}  // namespace ricochet::explicit_solver
