#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "coupler/protocols/hughes_liu.hpp"
#include "coupler/protocols/kim_predicted.hpp"
#include "coupler/spectrum/spectral_radius.hpp"
#include "coupler/spectrum/window_map.hpp"
#include "tests/coupler/protocols/spring_chain.hpp"

namespace ricochet::coupler::test {
namespace {

LinearMap map_of(const Eigen::MatrixXd& matrix) {
  auto x = std::make_shared<Eigen::VectorXd>();
  return {matrix.rows(), [x](const Eigen::VectorXd& given) { *x = given; },
          [x, matrix](std::int64_t windows) {
            while (windows-- > 0) *x = matrix * *x;
          },
          [x](Eigen::VectorXd& out) { out = *x; }};
}

TEST(ExactSpectralRadius, OfMatricesByHand) {
  Eigen::MatrixXd rotation(2, 2), rigid(2, 2), two(2, 2);
  rotation << 0.6, -0.8, 0.8, 0.6;
  rigid << 1.0, 1.0, 0.0, 1.0;  // u += dt v
  two << 1.0, 2.0, 3.0, 0.0;    // lambda^2 - lambda - 6: 3 and -2
  EXPECT_NEAR(exact_spectral_radius(map_of(rotation)).value, 1.0, 1e-14);
  EXPECT_TRUE(exact_spectral_radius(map_of(rotation)).stable());
  EXPECT_TRUE(exact_spectral_radius(map_of(rigid)).stable()) << "a Jordan block at 1 grows linearly, not by a factor";
  EXPECT_NEAR(exact_spectral_radius(map_of(two)).value, 3.0, 1e-13);
  EXPECT_FALSE(exact_spectral_radius(map_of(1.001 * rotation)).stable());
}

/// A map that answers the same whatever was loaded, as of a participant whose load_state does nothing.
TEST(ExactSpectralRadius, SaysNothingOfWhatIsNoLinearMap) {
  LinearMap deaf;
  deaf.size = 2;
  deaf.load = [](const Eigen::VectorXd&) {};
  deaf.advance = [](std::int64_t) {};
  deaf.read = [](Eigen::VectorXd& out) { out = Eigen::Vector2d(0.1, 0.2); };
  const auto radius = exact_spectral_radius(deaf);
  EXPECT_GT(radius.resolution, 0.01);
  EXPECT_FALSE(radius.known());
  EXPECT_FALSE(radius.stable());
  EXPECT_STREQ(radius.verdict(), "unknown");
}

/// Two bars of springs, the first explicit, which share a node; 2 x 61 unknowns and two link inputs.
struct Chains {
  static constexpr int springs = 30;
  explicit Chains(double dt)
      : left("left", false, Chain::of(std::vector<double>(springs, 1.0), std::vector<double>(springs, 1.0), 0.0),
             {springs}, Eigen::VectorXd::Zero(springs + 1)),
        right("right", true, Chain::of(std::vector<double>(springs, 9.0), std::vector<double>(springs, 1.0), springs),
              {0}, Eigen::VectorXd::Zero(springs + 1)),
        coupling(couple({&left, &right}, dt)) {}
  FakeParticipant left, right;
  std::unique_ptr<Coupling> coupling;
};

/// 2 / omega_max of the chain of unit springs whose end nodes have masses 1/2 and 1 (shared): from its own matrices.
double critical_step_of_chains() {
  auto chain = Chain::of(std::vector<double>(Chains::springs, 1.0), std::vector<double>(Chains::springs, 1.0), 0.0);
  chain.mass[Chains::springs] = 1.0;
  const Eigen::VectorXd root = chain.mass.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = root.asDiagonal() * chain.stiffness * root.asDiagonal();
  return 2.0 / std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues().maxCoeff());
}

TEST(WindowMap, HasAllUnknownsOfTheSchemeAndIsLinear) {
  Chains chains(0.5);
  HughesLiu protocol;
  const auto map = window_map(*chains.coupling, protocol, FrozenContact::open);
  EXPECT_EQ(map.size, 2 * (Chains::springs + Chains::springs + 1) + 2);
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(map.size, -1.0, 2.0), y = x.array().sin(), tx, ty, sum;
  const auto apply = [&](const Eigen::VectorXd& from, Eigen::VectorXd& to) {
    map.load(from);
    map.advance(3);
    map.read(to);
  };
  apply(x, tx);
  apply(y, ty);
  apply(2.0 * x - 3.0 * y, sum);
  EXPECT_LT((sum - (2.0 * tx - 3.0 * ty)).norm(), 1e-12 * sum.norm());
}

TEST(SpectralRadius, OfHughesLiuIsOneBelowTheCriticalStepOfTheExplicitElements) {
  for (const double courant : {0.3, 0.999}) {
    Chains chains(courant * critical_step_of_chains());
    HughesLiu protocol;
    EXPECT_TRUE(spectral_radius(window_map(*chains.coupling, protocol, FrozenContact::open)).stable()) << courant;
  }
  Chains chains(1.001 * critical_step_of_chains());
  HughesLiu protocol;
  // |lambda| = x + sqrt(x^2 - 1), x = 2 C^2 - 1, of the mode that the critical step is about
  const double x = 2.0 * 1.001 * 1.001 - 1.0;
  EXPECT_NEAR(spectral_radius(window_map(*chains.coupling, protocol, FrozenContact::open)).value,
              x + std::sqrt(x * x - 1.0), 5e-3);
}

TEST(IteratedSpectralRadius, FindsWhatTheDenseEigenvaluesAre) {
  for (const double courant : {0.9, 0.999, 1.01}) {
    Chains chains(courant * critical_step_of_chains());
    KimPredicted protocol;
    const auto map = window_map(*chains.coupling, protocol, FrozenContact::open);
    const auto exact = exact_spectral_radius(map), iterated = iterated_spectral_radius(map);
    EXPECT_FALSE(exact.stable());
    EXPECT_FALSE(iterated.stable());
    EXPECT_NEAR(iterated.value, exact.value, 1e-3 * exact.growth()) << iterated.method;
  }
}

TEST(IteratedSpectralRadius, SeesNoGrowthInAStableSchemeAndSaysHowFine) {
  Chains chains(0.9 * critical_step_of_chains());
  HughesLiu protocol;
  const auto iterated = iterated_spectral_radius(window_map(*chains.coupling, protocol, FrozenContact::open));
  EXPECT_TRUE(iterated.stable());
  EXPECT_LT(std::abs(iterated.growth()), 1e-4) << "rigid motion grows linearly";
  EXPECT_NEAR(iterated.resolution, 0.5 * std::log(124.0) / 10'000, 1e-9);
  EXPECT_EQ(iterated.method, "growth");
}

}  // namespace
}  // namespace ricochet::coupler::test
