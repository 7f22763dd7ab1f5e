// Dual and iterated protocols against springs and masses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/error.hpp"
#include "coupler/protocols/protocol.hpp"
#include "tests/coupler/protocols/spring_chain.hpp"

namespace ricochet::coupler::test {
namespace {

using Eigen::VectorXd;

const std::vector<double> soft = {1.0, 2.0, 1.5, 1.0}, soft_masses = {1.0, 1.2, 0.8, 1.0};
const std::vector<double> stiff = {30.0, 20.0, 25.0, 40.0}, stiff_masses = {0.9, 1.1, 1.0, 0.7};

VectorXd wave(int first) {
  VectorXd v(5);
  for (int i = 0; i < 5; ++i) v[i] = 0.3 + std::cos(M_PI * (first + i) / 8.0);
  return v;
}

/// Nodes 0..4 explicit, 4..8 implicit, node 4 shared; coupled and started.
struct Coupled {
  Coupled(const std::string& name, double dt, int substeps = 1, ProtocolSettings settings = {}) {
    settings.substeps = substeps;
    protocol = make_protocol(name, settings);
    coupling = unstarted({&explicit_side, &implicit_side}, dt);
    wire::Initialize request;
    request.window_size_s = dt;
    request.substeps = substeps;
    protocol->start(*coupling, request);
  }
  void step() {
    protocol->step(*coupling, Step{.accepted_window = window, .absolute = window % 7 == 0});
    ++window;
  }
  [[nodiscard]] double momentum() const { return explicit_side.momentum() + implicit_side.momentum(); }
  [[nodiscard]] double energy() const { return explicit_side.energy() + implicit_side.energy(); }

  FakeParticipant explicit_side{"explicit", false, Chain::of(soft, soft_masses, 0.0), {4}, wave(0)};
  FakeParticipant implicit_side{"implicit", true, Chain::of(stiff, stiff_masses, 4.0), {0}, wave(4)};
  std::unique_ptr<Protocol> protocol;
  std::unique_ptr<Coupling> coupling;
  std::int64_t window = 0;
};

double critical_step() {
  const Chain chain = Chain::of(soft, soft_masses, 0.0);
  const Eigen::MatrixXd mass = chain.mass.asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(chain.stiffness, mass);
  return 2.0 / std::sqrt(modes.eigenvalues().maxCoeff());
}

TEST(PrakashHjelmstad, KeepsItsPseudoEnergyForEverySubsteppingAndConservesMomentum) {
  for (const int m : {1, 2, 3, 5, 10, 20}) {
    Coupled run("prakash_hjelmstad", 0.9 * m * critical_step(), m);
    const auto pseudo = [&] { return run.explicit_side.pseudo_energy() + run.implicit_side.pseudo_energy(); };
    const double before = pseudo(), momentum = run.momentum();
    double drift = 0.0, lost = 0.0;
    for (int n = 0; n < 2000; ++n) {
      run.step();
      drift = std::max(drift, std::abs(pseudo() - before));
      lost = std::max(lost, std::abs(run.momentum() - momentum));
    }
    EXPECT_LT(drift / before, 1e-8) << m;
    EXPECT_LT(lost / momentum, 1e-7) << m << ", K u rounds by 40 N/m times the path of some km";
    EXPECT_NEAR(run.explicit_side.v[4], run.implicit_side.v[0], 1e-9) << m;
  }
}

TEST(GravouilCombescure, DissipatesItsPseudoEnergyWithSubstepsAndOnlyThen) {
  for (const int m : {1, 2, 5}) {
    Coupled run("gravouil_combescure", 0.5 * m * critical_step(), m);
    double last = run.energy();
    const double before = last;
    for (int n = 0; n < 4000; ++n) run.step();
    if (m == 1) {
      EXPECT_NEAR(run.energy() / before, 1.0, 0.3);
    } else {
      EXPECT_LT(run.energy(), 0.5 * before) << m;
    }
    EXPECT_NEAR(run.explicit_side.v[4], run.implicit_side.v[0], 1e-9) << m;
  }
}

TEST(DualProtocols, AreTheSameWithOneSubstep) {
  Coupled a("prakash_hjelmstad", 0.4), b("gravouil_combescure", 0.4);
  for (int n = 0; n < 500; ++n) a.step(), b.step();
  EXPECT_LT((a.explicit_side.u - b.explicit_side.u).norm() / a.explicit_side.u.norm(), 1e-11);
}

/// Two explicit participants that meet each other and the implicit one at a node.
TEST(DualProtocols, SeveralExplicitParticipantsMayMeetAtANode) {
  const Chain left = Chain::of(soft, soft_masses, 0.0), middle = Chain::of(stiff, stiff_masses, 4.0);
  Chain branch = Chain::of({2.0, 1.0}, {0.8, 0.6}, 4.0);  // from the shared node away
  branch.position[1] = -7.0, branch.position[2] = -8.0;
  Chain both{VectorXd(7), Eigen::MatrixXd::Zero(7, 7), VectorXd(7)};
  both.mass << left.mass.head(4), left.mass[4] + branch.mass[0], branch.mass.tail(2);
  both.position << left.position, branch.position.tail(2);
  both.stiffness.topLeftCorner(5, 5) += left.stiffness;
  both.stiffness.bottomRightCorner(3, 3) += branch.stiffness;
  VectorXd v(7);
  v << wave(0), 0.2, 0.4;
  for (const int m : {1, 3}) {
    const double dt = 0.4 * m;
    FakeParticipant one("both", false, both, {4}, v), middle_1("implicit", true, middle, {0}, wave(4));
    FakeParticipant a("a", false, left, {4}, v.head(5)), b("b", false, branch, {0}, v.tail(3));
    FakeParticipant middle_2("implicit", true, middle, {0}, wave(4));
    auto single = unstarted({&one, &middle_1}, dt), twice = unstarted({&b, &middle_2, &a}, dt);
    wire::Initialize request;
    request.window_size_s = dt;
    request.substeps = m;
    const auto first = make_protocol("prakash_hjelmstad", {}), second = make_protocol("prakash_hjelmstad", {});
    first->start(*single, request);
    second->start(*twice, request);
    for (int n = 0; n < 300; ++n) {
      first->step(*single, Step{.accepted_window = n});
      second->step(*twice, Step{.accepted_window = n});
    }
    // With substeps the two are no longer held together within the window, so only one step gives the same motion.
    EXPECT_LT((middle_1.u - middle_2.u).norm() / middle_1.u.norm(), m == 1 ? 1e-10 : 1e-3) << m;
    EXPECT_NEAR(a.v[4], b.v[0], 1e-9) << m;
  }
}

TEST(DualProtocols, RefuseAParticipantWithoutMassAtTheInterface) {
  Chain massless = Chain::of(soft, soft_masses, 0.0);
  massless.mass[4] = 0.0;
  FakeParticipant light("light", false, massless, {4}, wave(0)),
      heavy("implicit", true, Chain::of(stiff, stiff_masses, 4.0), {0}, wave(4));
  auto coupling = unstarted({&light, &heavy}, 0.1);
  wire::Initialize request;
  request.window_size_s = 0.1;
  try {
    make_protocol("prakash_hjelmstad", {})->start(*coupling, request);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'light'"), testing::HasSubstr("no mass")));
  }
}

TEST(UnitResponses, OfASolverThatDoesNotStartAgainAreRefused) {
  FakeParticipant left("forgetful", false, Chain::of(soft, soft_masses, 0.0), {0, 4}, wave(0));
  Chain ends = Chain::of(stiff, stiff_masses, 4.0);
  ends.position[4] = 0.0;
  FakeParticipant right("implicit", true, ends, {0, 4}, VectorXd::Zero(5));
  left.forgets_to_restore = true;
  auto coupling = unstarted({&left, &right}, 0.4);
  wire::Initialize request;
  request.window_size_s = 0.4;
  request.substeps = 3;
  try {
    make_protocol("prakash_hjelmstad", {})->start(*coupling, request);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'forgetful'"),
                                             testing::HasSubstr("does not answer the same link input alike"),
                                             testing::HasSubstr("allowed: a repeated window that starts from")));
  }
}

TEST(BelytschkoMullen, ConservesMomentumAndIsWhatFixedPointConvergesTo) {
  Coupled direct("belytschko_mullen", 0.4);
  const double before = direct.momentum();
  ProtocolSettings settings;
  settings.tolerance = 1e-12;
  Coupled iterated("fixed_point", 0.4, 1, settings);
  double lost = 0.0;
  for (int n = 0; n < 500; ++n) {
    direct.step();
    iterated.step();
    lost = std::max(lost, std::abs(direct.momentum() - before));
  }
  EXPECT_LT(lost / before, 1e-10);
  EXPECT_LT((direct.implicit_side.u - iterated.implicit_side.u).norm() / direct.implicit_side.u.norm(), 1e-9);
}

int iterations_of(const std::string& acceleration) {
  ProtocolSettings settings;
  settings.acceleration = acceleration;
  Coupled run("fixed_point", 0.9 * critical_step(), 1, settings);
  run.explicit_side.asked.clear();
  for (int n = 0; n < 100; ++n) run.step();
  return static_cast<int>(std::count(run.explicit_side.asked.begin(), run.explicit_side.asked.end(), "advance"));
}

TEST(FixedPoint, AcceleratesAsItSays) {
  const int constant = iterations_of("constant"), aitken = iterations_of("aitken"), iqn_ils = iterations_of("iqn_ils");
  EXPECT_LT(aitken, constant / 3);
  EXPECT_LE(iqn_ils, aitken);
  EXPECT_LE(iqn_ils, 400) << "one unknown: a secant";
}

// The tolerance is one of a window's increment: how far the bodies have flown since the start must not loosen it.
TEST(FixedPoint, IteratesNoLessAfterALongFlight) {
  ProtocolSettings settings;
  settings.acceleration = "constant";
  settings.max_iterations = 500;
  Coupled run("fixed_point", 0.9 * critical_step(), 1, settings);
  const auto asked_in = [&run](int windows) {
    run.explicit_side.asked.clear();
    for (int n = 0; n < windows; ++n) run.step();
    return static_cast<int>(std::count(run.explicit_side.asked.begin(), run.explicit_side.asked.end(), "advance"));
  };
  const int early = asked_in(200);
  (void)asked_in(5000);
  EXPECT_GT(asked_in(200), 0.95 * early);
}

TEST(FixedPoint, SaysThatItDoesNotConverge) {
  ProtocolSettings settings;
  settings.max_iterations = 2;
  Coupled run("fixed_point", 0.4, 1, settings);
  try {
    run.step();
    FAIL();
  } catch (const SolverError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("window 1"), testing::HasSubstr("max_iterations = 2")));
  }
  EXPECT_EQ(run.protocol->note(), "");
}

}  // namespace
}  // namespace ricochet::coupler::test
