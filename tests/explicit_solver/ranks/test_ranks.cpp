// A participant of several ranks computes the bits of one without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "explicit_solver/explicit_solver.hpp"
#include "tests/support/places.hpp"
#include "tests/support/ranks_in_threads.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::explicit_solver {
namespace {

/// Everything that may act on a plate: a load, a shaken and a held side, dashpots; part of it is implicit.
const std::string loaded_plate = R"(model = "plane_strain"
[[body]]
name = "plate"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.6, height_m = 0.2, elements = [9, 29] }
initial_velocity_m_s = [3.0, 7.0]
LOADS
[[body.support]]
surface = "inner"
fixed = ["x"]
[[body.absorbing]]
surface = "end"
wave = "dilatational"
[contact]
surfaces = ["plate.start", "rigid_plane"]
[partition]
implicit_length_m = { plate = 0.05 }
[[participant]]
name = "explicit"
role = "explicit"
bodies = ["plate"]
[[participant]]
name = "implicit"
role = "implicit"
[time]
safety_factor = 0.8
end_s = 1.0
[coupling]
)";
const std::string plate_loads = R"(gravity_m_s2 = [0.0, -9.81]
[[body.traction]]
surface = "outer"
traction_pa = [1e5, 2e4]
)";
const std::string blocks = R"(model = "solid"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.06, length_m = 0.06, height_m = 0.03, width_m = 0.04, elements = [4, 3, 6] }
initial_velocity_m_s = [2.0, 1.0, 9.0]
[[body]]
name = "upper"
material = { youngs_modulus_pa = 2e9, poisson_ratio = 0.25, density_kg_m3 = 1500.0 }
mesh = { length_m = 0.05, height_m = 0.03, width_m = 0.04, elements = [4, 3, 5] }
[contact]
surfaces = ["lower.end", "upper.start"]
friction_coefficient = 0.2
[time]
safety_factor = 0.8
end_s = 1.0
[coupling]
protocol = "all_explicit"
)";

/// With materials that yield soon, harden, follow the rate and are heated.
std::string yielding(const std::string& text) {
  std::string all = text;
  const std::string of_elastic = "00.0 }",
                    of_yielding =
                        "00.0, plasticity = { yield_stress_pa = 2e3, hardening_pa = 1e8, rate_factor = 0.01, heat = { "
                        "specific_heat_j_kg_k = 477.0, melting_k = 1793.0 } } }";
  for (auto at = all.find(of_elastic); at != std::string::npos; at = all.find(of_elastic, at + of_yielding.size()))
    all.replace(at, of_elastic.size(), of_yielding);
  return all;
}

/// Bodies that turn, and spin.
std::string turning(const std::string& text) {
  std::string all = text;
  const std::string name = "initial_velocity_m_s = [2.0";
  return test::replaced(all, name,
                        "large_rotation = true\ninitial_angular_velocity_rad_s = [300.0, -800.0, 100.0]\n" + name);
}

std::string config_of(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(test::source_folder() + "/configs/" + name + ".toml").rdbuf();
  return text.str() + "\n[coupling]\nprotocol = \"all_explicit\"\n";
}

struct RankedScene {
  std::string name, text;
  participant::Drive drive = participant::Drive::displacement;
  int substeps = 1;
};
void PrintTo(const RankedScene& c, std::ostream* out) { *out << c.name; }

const RankedScene ranked_scenes[] = {
    {"moved_plate", test::replaced(loaded_plate, "LOADS", "") + "protocol = \"hughes_liu\"\n"},
    {"moved_and_loaded_plate", test::replaced(loaded_plate, "LOADS", plate_loads) + "protocol = \"hughes_liu\"\n"},
    {"pushed_plate", test::replaced(loaded_plate, "LOADS", "") + "protocol = \"prakash_hjelmstad\"\nsubsteps = 4\n",
     participant::Drive::force, 4},
    {"pushed_and_loaded_plate",
     test::replaced(loaded_plate, "LOADS", plate_loads) + "protocol = \"prakash_hjelmstad\"\nsubsteps = 3\n",
     participant::Drive::force, 3},
    {"sliding_blocks", blocks},
    {"massless_blocks", test::replaced(blocks, "friction", "multiplier_update = \"massless\"\nfriction")},
    {"yielding_moved_plate",
     yielding(test::replaced(loaded_plate, "LOADS", plate_loads)) + "protocol = \"hughes_liu\"\n"},
    {"yielding_pushed_plate",
     yielding(test::replaced(loaded_plate, "LOADS", plate_loads)) + "protocol = \"prakash_hjelmstad\"\nsubsteps = 1\n",
     participant::Drive::force, 1},
    {"yielding_blocks", yielding(blocks)},
    {"turning_blocks", turning(blocks)},
    {"turning_and_yielding_blocks", yielding(turning(blocks))},
    {"bars", config_of("two_bars")},
    {"cylinders", config_of("kim_impact")},
};

/// A solver of one process, and one of several ranks.
class Ranked : public testing::TestWithParam<std::tuple<RankedScene, int>> {
 protected:
  void SetUp() override {
    const auto& [c, count] = GetParam();
    const test::TemporaryFolder folder;
    problem_ = scene::build_problem(scene::load_scene(folder.write(c.text)));
    ranks_.emplace(problem_, "explicit", count);
    whole_.emplace(problem_, "explicit");
    ranked_.emplace(problem_, "explicit", std::nullopt, &ranks_->first);
    setup_.clock = problem_.clock.size_s();
    setup_.substeps = c.substeps;
    setup_.driven_by = c.drive;
    setup_.last_window = 1000;
    setup_.interface_mass_kg = whole_->describe().interface_mass_kg;
    ASSERT_EQ(ranked_->describe().record_columns, whole_->describe().record_columns);
    each([&](ExplicitSolver& solver, participant::LinkOutput& output) { solver.initialize(setup_, output); });
    const std::vector<double> rest(output_.value.size(), 0.0);
    each([&](ExplicitSolver& solver, participant::LinkOutput& output) {
      solver.synchronise(participant::Integration::implicit_newmark, rest, output);
    });
  }
  /// Does the same to both; what they answer has the same bits.
  template <class Call>
  void each(Call call) {
    participant::LinkOutput other;
    call(*ranked_, other);
    call(*whole_, output_);
    ASSERT_EQ(other.value, output_.value) << "window " << window_;
    ASSERT_EQ(other.velocity_m_s, output_.velocity_m_s) << "window " << window_;
    ASSERT_EQ(other.acceleration_m_s2, output_.acceleration_m_s2) << "window " << window_;
  }
  void step() {
    ++window_;
    const bool moved = setup_.driven_by == participant::Drive::displacement;
    std::vector<double> link(output_.value.size());
    for (std::size_t i = 0; i < link.size(); ++i)
      link[i] = (moved ? 1e-6 : 1e3) * std::sin(0.1 * static_cast<double>(window_) + 0.7 * static_cast<double>(i));
    each([&](ExplicitSolver& solver, participant::LinkOutput& output) {
      solver.advance(window_, std::vector<double>(link.size(), 1e-7), output);  // a trial that is given up
      solver.advance(window_, link, output);
      solver.accept();
      solver.work_ahead();
    });
  }
  void expect_same_reports() {
    std::vector<double> expected, found;
    whole_->record(expected);
    ranked_->record(found);
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_EQ(found[i], expected[i]) << whole_->describe().record_columns[i] << ", window " << window_;
    whole_->axial_stress(expected);
    ranked_->axial_stress(found);
    ASSERT_EQ(found, expected) << "window " << window_;
    const auto outline = whole_->outline(), of_ranks = ranked_->outline();
    ASSERT_EQ(of_ranks.size(), outline.size());
    for (std::size_t i = 0; i < outline.size(); ++i)
      ASSERT_EQ(of_ranks[i].displacement_m, outline[i].displacement_m) << "window " << window_;
  }

  scene::Problem problem_;
  participant::Setup setup_;
  std::optional<test::RanksInThreads> ranks_;
  std::optional<ExplicitSolver> whole_, ranked_;
  participant::LinkOutput output_;
  std::int64_t window_ = 0;
};

TEST_P(Ranked, GiveTheSameBits) {
  for (int i = 0; i < 60; ++i) {
    ASSERT_NO_FATAL_FAILURE(step());
    ASSERT_NO_FATAL_FAILURE(expect_same_reports());
  }
  for (const auto& state : whole_->stepping().states()) {
    if (!state.plastic) continue;
    EXPECT_GT(state.plastic->work_j.sum(), 0.0) << "nothing yielded";
  }
  whole_->finish();
  ranked_->finish();
}

TEST_P(Ranked, GoOnFromASavedState) {
  for (int i = 0; i < 10; ++i) ASSERT_NO_FATAL_FAILURE(step());
  const auto of_whole = whole_->save_state(), of_ranks = ranked_->save_state();
  const auto then = window_;
  for (int i = 0; i < 5; ++i) ASSERT_NO_FATAL_FAILURE(step());
  std::vector<double> expected, found, discarded;
  ranked_->record(expected);
  whole_->record(discarded);
  whole_->restore_state(of_whole);
  ranked_->restore_state(of_ranks);
  window_ = then;
  for (auto* solver : {&*whole_, &*ranked_}) solver->work_ahead();  // as before
  for (int i = 0; i < 5; ++i) ASSERT_NO_FATAL_FAILURE(step());
  ranked_->record(found);
  whole_->record(discarded);
  EXPECT_EQ(found, expected);
  ASSERT_NO_FATAL_FAILURE(expect_same_reports());
}

INSTANTIATE_TEST_SUITE_P(Ranks, Ranked,
                         testing::Combine(testing::ValuesIn(ranked_scenes), testing::Values(1, 2, 3, 4, 7)),
                         [](const testing::TestParamInfo<std::tuple<RankedScene, int>>& test) {
                           return std::get<0>(test.param).name + "_" + std::to_string(std::get<1>(test.param));
                         });

TEST(Ranks, OfferNoStateToLoad) {
  const test::TemporaryFolder folder;
  const auto problem = scene::build_problem(scene::load_scene(folder.write(config_of("two_bars"))));
  test::RanksInThreads ranks(problem, "explicit", 2);
  ExplicitSolver solver(problem, "explicit", {}, &ranks.first);
  EXPECT_THAT(solver.describe().capabilities, testing::Not(testing::Contains(Capability::load_state)));
}

}  // namespace
}  // namespace ricochet::explicit_solver
