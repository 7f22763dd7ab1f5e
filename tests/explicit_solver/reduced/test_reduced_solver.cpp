// A participant of modes, moved by hand: what it answers, books, saves and refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/ledger.hpp"
#include "explicit_solver/reduced/reduced_solver.hpp"
#include "tests/support/scene_file.hpp"

namespace ricochet::explicit_solver {
namespace {

/// A plate that flies onto another one; SUPPORT of the upper one, whose modes they are.
std::string plates_with(const std::string& support, int modes) {
  return R"(model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.05, length_m = 0.05, height_m = 0.02, elements = [2, 5] }
[[body]]
name = "upper"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.05, height_m = 0.02, elements = [2, 5] }
initial_velocity_m_s = [0.5, -2.0]
)" + support +
         R"([contact]
surfaces = ["lower.end", "upper.start"]
[partition]
implicit_length_m = { lower = 0.01, upper = 0.01 }
reduced_modes = { upper = )" +
         std::to_string(modes) + R"( }
[time]
step_s = 2e-6
end_s = 1e-3
[coupling]
protocol = "belytschko_mullen"
)";
}

class Reduced {
 public:
  explicit Reduced(const std::string& text)
      : solver_(scene::build_problem(scene::load_scene(folder_.write(text))), "reduced"),
        description_(solver_.describe()) {
    setup_.clock = 2e-6;
    setup_.last_window = 1000;
    setup_.interface_mass_kg = description_.interface_mass_kg;
    participant::LinkOutput output;
    solver_.initialize(setup_, output);
    solver_.synchronise(participant::Integration::explicit_central, motion(0), output);
    force_.push_back(output.value);
    record();
  }

  /// Flies with its velocity at the start, shaken about that.
  [[nodiscard]] std::vector<double> motion(int window) const {
    std::vector<double> u;
    for (std::size_t i = 0; i < 2 * description_.interface_mass_kg.size(); ++i) {
      const double t_s = 2e-6 * window;
      const double shaken = 1e-5 * std::sin(4e4 * t_s * (1.0 + 0.1 * static_cast<double>(i)));
      u.push_back((i % 2 == 0 ? 0.5 : -2.0) * t_s + shaken);
    }
    return u;
  }

  void window(int number) {
    participant::LinkOutput output;
    solver_.advance(number, motion(number + 7), output);  // a trial that nobody accepts
    solver_.advance(number, motion(number), output);
    solver_.accept();
    force_.push_back(output.value);
    record();
  }

  [[nodiscard]] double of(std::size_t row, const std::string& quantity) const {
    for (std::size_t c = 0; c < description_.record_columns.size(); ++c)
      if (description_.record_columns[c] == quantity + "/upper") return rows_[row][c];
    throw std::invalid_argument(quantity);
  }
  [[nodiscard]] double last(const std::string& quantity) const { return of(rows_.size() - 1, quantity); }
  /// dt/2 (P_n + P_n+1), summed over windows and nodes, along a component.
  [[nodiscard]] double given(std::size_t component) const {
    double sum = 0.0;
    for (std::size_t n = 0; n + 1 < force_.size(); ++n)
      for (std::size_t i = component; i < force_[n].size(); i += 2) sum += 1e-6 * (force_[n][i] + force_[n + 1][i]);
    return sum;
  }

  test::TemporaryFolder folder_;
  ReducedSolver solver_;
  participant::Description description_;
  participant::Setup setup_;
  std::vector<std::vector<double>> force_, rows_;

 private:
  void record() {
    rows_.emplace_back();
    solver_.record(rows_.back());
  }
};

TEST(ReducedSolver, HasNoMassAtSharedNodes) {
  const Reduced reduced(plates_with("", 20));
  EXPECT_EQ(reduced.description_.interface_mass_kg, std::vector<double>(3, 0.0));
  EXPECT_EQ(reduced.description_.critical_time_step_s, 0.0);
  EXPECT_NEAR(reduced.of(0, "mass_kg"), 0.8, 1e-12) << "four of five layers of elements";
}

// The work of the link is what its energy changes by, the impulse of link and supports what its momenta do.
TEST(ReducedSolver, KeepsWhatItIsGiven) {
  for (const std::string support : {"", "support = [{ surface = \"end\", fixed = [\"x\"] }]\n"}) {
    for (const int modes : {3, 20}) {
      Reduced reduced(plates_with(support, modes));
      for (int n = 1; n <= 200; ++n) reduced.window(n);
      const auto change = [&](const std::string& quantity) { return reduced.last(quantity) - reduced.of(0, quantity); };
      const double energy_j = reduced.of(0, "energy_kinetic_j");
      EXPECT_GT(reduced.last("energy_strain_j"), 1e-3 * energy_j);
      EXPECT_NEAR(change("energy_kinetic_j") + change("energy_strain_j"), change("energy_interface_j"),
                  1e-9 * energy_j);
      // n is the axis y, t = -x.
      const double largest = std::abs(reduced.of(0, "momentum_n_kg_m_s"));
      EXPECT_NEAR(std::abs(change("momentum_n_kg_m_s") - change("impulse_n_kg_m_s")), std::abs(reduced.given(1)),
                  1e-8 * largest);
      EXPECT_NEAR(std::abs(change("momentum_t_kg_m_s") - change("impulse_t_kg_m_s")), std::abs(reduced.given(0)),
                  1e-8 * largest);
      EXPECT_EQ(reduced.last("impulse_t_kg_m_s") != 0.0, !support.empty());
      EXPECT_LE(reduced.last("energy_highest_modes_j"),
                reduced.last("energy_kinetic_j") + reduced.last("energy_strain_j"));
    }
  }
}

TEST(ReducedSolver, GoesOnFromItsStateToTheSameBits) {
  Reduced one(plates_with("", 12)), other(plates_with("", 12));
  for (int n = 1; n <= 20; ++n) one.window(n);
  other.solver_.restore_state(one.solver_.save_state());
  other.force_.back() = one.force_.back();
  for (int n = 21; n <= 30; ++n) {
    one.window(n);
    other.window(n);
    EXPECT_EQ(other.force_.back(), one.force_.back());
    EXPECT_EQ(other.rows_.back(), one.rows_.back());
  }
  const std::string state = one.solver_.save_state();
  EXPECT_THROW(other.solver_.restore_state(state.substr(0, state.size() / 2)), ConfigError);
  EXPECT_THROW(other.solver_.restore_state(state + "more"), ConfigError);
  Reduced another(plates_with("", 11));
  EXPECT_THROW(another.solver_.restore_state(state), ConfigError);
}

TEST(ReducedSolver, LoadsAndTellsItsModes) {
  Reduced reduced(plates_with("", 5));
  std::vector<double> state, scale, again;
  for (int i = 0; i < 10; ++i) state.push_back(0.1 * i - 0.3);
  reduced.solver_.load_state(state, {});
  reduced.solver_.read_state(again, scale);
  EXPECT_EQ(again, state);
  EXPECT_EQ(scale.front(), 1.0 / 2e-6);
  EXPECT_EQ(scale.back(), 1.0);
}

TEST(ReducedSolver, RefusesToGoOnWithNumbersThatMeanNothing) {
  Reduced reduced(plates_with("", 5));
  reduced.solver_.load_state(std::vector<double>(10, std::nan("")), {});
  std::vector<double> row;
  EXPECT_THROW(reduced.solver_.record(row), SolverError);
}

// `check` refuses it; a participant that somebody starts by hand does, too.
TEST(ReducedSolver, RefusesMoreModesThanThereAre) {
  EXPECT_THROW(Reduced(plates_with("", 25)), ConfigError);
  EXPECT_THROW(Reduced(plates_with("", 24)), SolverError)
      << "the six that are left do not move the shared nodes in six ways";
  EXPECT_NO_THROW(Reduced(plates_with("", 20)));
}

}  // namespace
}  // namespace ricochet::explicit_solver
