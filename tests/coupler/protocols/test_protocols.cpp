// The protocols against springs and masses whose exact motion is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/scene/protocols.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/protocols/protocol.hpp"
#include "tests/coupler/protocols/spring_chain.hpp"
#include "tests/support/places.hpp"

namespace ricochet::coupler::test {
namespace {

using Eigen::VectorXd;

// Nodes 0..4 explicit, 4..8 implicit: node 4 is shared.
const std::vector<double> left_springs = {1.0, 2.0, 1.5, 1.0}, left_masses = {1.0, 1.2, 0.8, 1.0};
const std::vector<double> right_springs = {30.0, 20.0, 25.0, 40.0}, right_masses = {0.9, 1.1, 1.0, 0.7};

struct Pair {
  FakeParticipant explicit_side{"explicit", false, Chain::of(left_springs, left_masses, 0.0), {4}, initial(0)};
  FakeParticipant implicit_side{"implicit", true, Chain::of(right_springs, right_masses, 4.0), {0}, initial(4)};

  /// Smooth: one wave over the whole chain, the ends at different speeds so that there is momentum.
  static VectorXd initial(int first) {
    VectorXd v(5);
    for (int i = 0; i < 5; ++i) v[i] = 0.3 + std::cos(M_PI * (first + i) / 8.0);
    return v;
  }
  static VectorXd initial_explicit() {
    VectorXd v = initial(0);
    v[4] = 0.0;  // shared: integrated by the implicit side
    return v;
  }
  Pair() { explicit_side.v = initial_explicit(); }

  std::unique_ptr<Coupling> coupling(double dt) { return couple({&explicit_side, &implicit_side}, dt); }
  [[nodiscard]] double momentum() const { return explicit_side.momentum() + implicit_side.momentum(); }
  [[nodiscard]] double energy() const { return explicit_side.energy() + implicit_side.energy(); }
};

/// Displacement of the nine nodes at time t by modal superposition.
VectorXd exact(double t) {
  std::vector<double> springs = left_springs, masses = left_masses;
  springs.insert(springs.end(), right_springs.begin(), right_springs.end());
  masses.insert(masses.end(), right_masses.begin(), right_masses.end());
  const Chain chain = Chain::of(springs, masses, 0.0);
  VectorXd v0(9);
  v0 << Pair::initial(0).head(4), Pair::initial(4);
  const Eigen::MatrixXd mass = chain.mass.asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(chain.stiffness, mass);
  const VectorXd q = modes.eigenvectors().transpose() * mass * v0;
  VectorXd amplitude(9);
  for (int i = 0; i < 9; ++i) {
    const double omega = std::sqrt(std::max(0.0, modes.eigenvalues()[i]));
    amplitude[i] = omega > 1e-6 ? q[i] * std::sin(omega * t) / omega : q[i] * t;
  }
  return modes.eigenvectors() * amplitude;
}

double error_at(const std::string& protocol_name, int steps, bool switched = false) {
  const double end = 2.0;
  Pair pair;
  auto coupling = pair.coupling(end / steps);
  const auto protocol = make_protocol(protocol_name, {});
  if (switched) coupling->synchronise(Integration::explicit_central);
  for (int n = 0; n < steps; ++n) protocol->step(*coupling, Step{n, 1, n % 7 == 0, false});
  const VectorXd reference = exact(end);
  return std::max((pair.explicit_side.u.head(4) - reference.head(4)).lpNorm<Eigen::Infinity>(),
                  (pair.implicit_side.u - reference.tail(5)).lpNorm<Eigen::Infinity>());
}

class SecondOrder : public testing::TestWithParam<std::pair<const char*, bool>> {};

TEST_P(SecondOrder, ErrorFallsWithTheSquareOfTheStep) {
  const auto [protocol, switched] = GetParam();
  const double coarse = error_at(protocol, 200, switched), fine = error_at(protocol, 400, switched);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1) << protocol << ": " << coarse << " -> " << fine;
  EXPECT_LT(fine, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(Protocols, SecondOrder,
                         testing::Values(std::pair{"hughes_liu", false}, std::pair{"kim", false},
                                         std::pair{"hughes_liu", true}, std::pair{"kim", true}));

TEST(HughesLiu, ConservesMomentumToRoundOff) {
  Pair pair;
  auto coupling = pair.coupling(0.4);
  const auto protocol = make_protocol("hughes_liu", {});
  const double before = pair.momentum();
  double largest = 0.0;
  for (int n = 0; n < 500; ++n) {
    protocol->step(*coupling, Step{n, 1, false, false});
    largest = std::max(largest, std::abs(pair.momentum() - before));
  }
  EXPECT_GT(before, 1.0);
  // The chain travels some 60 m: K u rounds by 40 N/m * 60 m * 1e-16 a window, 500 of them.
  EXPECT_LT(largest / before, 1e-11);
}

TEST(Kim, MomentumErrorIsSmallButNotRoundOff) {
  Pair pair;
  auto coupling = pair.coupling(0.1);
  const auto protocol = make_protocol("kim", {});
  const double before = pair.momentum();
  double largest = 0.0;
  for (int n = 0; n < 500; ++n) {
    protocol->step(*coupling, Step{n, 1, false, false});
    largest = std::max(largest, std::abs(pair.momentum() - before));
  }
  EXPECT_GT(largest / before, 1e-10);
  EXPECT_LT(largest / before, 1e-2);
}

/// Largest energy over its start in many steps at the given step.
double energy_growth(const std::string& protocol_name, double dt, int steps) {
  Pair pair;
  auto coupling = pair.coupling(dt);
  const auto protocol = make_protocol(protocol_name, {});
  const double before = pair.energy();
  double largest = 0.0;
  for (int n = 0; n < steps && largest < 1e6; ++n) {
    protocol->step(*coupling, Step{n, 1, false, false});
    largest = std::max(largest, pair.energy() / before);
  }
  return largest;
}

/// 2/omega_max of the explicit springs with the summed mass at the shared node.
double critical_step_of_two_chains() {
  Chain left = Chain::of(left_springs, left_masses, 0.0);
  left.mass[4] += 0.5 * right_masses[0];
  const Eigen::MatrixXd mass = left.mass.asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(left.stiffness, mass);
  return 2.0 / std::sqrt(modes.eigenvalues().maxCoeff());
}

TEST(Stability, HughesLiuAndKimUpToTheExplicitLimit) {
  for (const auto* protocol : {"hughes_liu", "kim"}) {
    EXPECT_LT(energy_growth(protocol, 0.98 * critical_step_of_two_chains(), 20000), 60.0) << protocol;
    EXPECT_GT(energy_growth(protocol, 1.03 * critical_step_of_two_chains(), 20000), 1e5) << protocol;
  }
}

TEST(Stability, KimPredictedGrowsWhereKimDoesNot) {
  EXPECT_GT(energy_growth("kim_predicted", 0.8 * critical_step_of_two_chains(), 20000), 1e5);
  EXPECT_LT(energy_growth("kim", 0.8 * critical_step_of_two_chains(), 20000), 10.0);
  EXPECT_THAT(scene::protocol_traits("kim_predicted").trouble, testing::HasSubstr("unstable"));
}

TEST(Exchange, KimRepeatsTheExplicitWindowUnlessAllIsExplicit) {
  Pair pair;
  auto coupling = pair.coupling(0.1);
  const auto protocol = make_protocol("kim", {});
  pair.explicit_side.asked.clear();
  protocol->step(*coupling, Step{0, 1, false, false});
  EXPECT_THAT(pair.explicit_side.asked, testing::ElementsAre("advance", "advance"));
  coupling->synchronise(Integration::explicit_central);
  pair.explicit_side.asked.clear();
  protocol->step(*coupling, Step{1, 1, false, false});
  EXPECT_THAT(pair.explicit_side.asked, testing::ElementsAre("advance"));
}

TEST(Exchange, ResynchronisationChangesNothingButRoundOff) {
  VectorXd displacement[2];
  for (const int every : {0, 5}) {
    Pair pair;
    auto coupling = pair.coupling(0.3);
    const auto protocol = make_protocol("kim", {});
    for (int n = 0; n < 2000; ++n) protocol->step(*coupling, Step{n, 1, every > 0 && (n + 1) % every == 0, false});
    displacement[every > 0 ? 1 : 0] = pair.implicit_side.u;
    EXPECT_LT(coupling->largest_drift(), 1e-11);
  }
  EXPECT_LT((displacement[0] - displacement[1]).norm() / displacement[0].norm(), 1e-9);
}

TEST(Exchange, ResynchronisationFindsDrift) {
  Pair pair;
  auto coupling = pair.coupling(0.3);
  pair.explicit_side.corrupt_increment = 1e-6;
  const auto protocol = make_protocol("hughes_liu", {});
  for (int n = 0; n < 100; ++n) protocol->step(*coupling, Step{n, 1, n == 99, false});
  EXPECT_GT(coupling->largest_drift(), 1e-6);
}

/// The preparation of one takes none of the others' time.
TEST(Exchange, EverybodyIsInitialisedAtTheSameTime) {
  Pair pair;
  std::vector<std::string> order;
  const auto noted = [&order](Peer peer) {
    const auto post = peer.post;
    const auto wait = peer.wait;
    peer.post = [&order, post, name = peer.name](wire::Message& message) {
      if (message.kind == wire::Kind::initialize) order.push_back("asked " + name);
      post(message);
    };
    peer.wait = [&order, wait, name = peer.name]() -> wire::Message& {
      auto& answer = wait();
      if (answer.kind == wire::Kind::initialized) order.push_back("heard " + name);
      return answer;
    };
    return peer;
  };
  Coupling coupling({noted(pair.explicit_side.peer()), noted(pair.implicit_side.peer())},
                    {pair.explicit_side.description(), pair.implicit_side.description()}, 0.1);
  coupling.initialize({});
  EXPECT_THAT(order, testing::ElementsAre("asked explicit", "asked implicit", "heard explicit", "heard implicit"));
}

/// Implicit middle, explicit on either side: as one or as two explicit participants.
TEST(Exchange, OneOrTwoExplicitParticipantsAreBitIdentical) {
  const Chain middle = Chain::of(right_springs, right_masses, 4.0);
  const Chain left = Chain::of(left_springs, left_masses, 0.0), right = Chain::of(left_springs, left_masses, 8.0);
  Chain both{VectorXd(10), Eigen::MatrixXd::Zero(10, 10), VectorXd(10)};
  both.mass << left.mass, right.mass;
  both.position << left.position, right.position;
  both.stiffness.topLeftCorner(5, 5) = left.stiffness;
  both.stiffness.bottomRightCorner(5, 5) = right.stiffness;
  VectorXd v(10), still = VectorXd::Zero(5);
  v << 1.0, 0.9, 0.7, 0.4, 0.0, 0.0, -0.1, -0.3, -0.2, 0.5;

  FakeParticipant one("both", false, both, {4, 5}, v), middle_1("implicit", true, middle, {0, 4}, still);
  FakeParticipant a("a", false, left, {4}, v.head(5)), b("b", false, right, {0}, v.tail(5));
  FakeParticipant middle_2("implicit", true, middle, {0, 4}, still);
  auto single = couple({&one, &middle_1}, 0.3), twice = couple({&b, &middle_2, &a}, 0.3);
  const auto protocol = make_protocol("hughes_liu", {});
  for (int n = 0; n < 500; ++n) {
    protocol->step(*single, Step{n, 1, n % 10 == 9, false});
    protocol->step(*twice, Step{n, 1, n % 10 == 9, false});
  }
  EXPECT_TRUE((middle_1.u.array() == middle_2.u.array()).all());
  EXPECT_GT(middle_1.u.norm(), 0.1);
}

// As docs/contributing.md says, it takes a file named like it, a line in protocols.cpp, a row in the scene's table.
TEST(Registry, AProtocolIsAFileALineAndARowOfTheSceneTable) {
  EXPECT_THAT(implemented_protocols(), testing::UnorderedElementsAreArray(scene::protocol_names()));
  for (const auto& protocol : scene::protocols()) {
    EXPECT_NE(make_protocol(protocol.name, {}), nullptr);
    if (!protocol.coupled()) continue;
    const std::string file = ricochet::test::source_folder() + "/coupler/protocols/" + protocol.name + ".hpp";
    EXPECT_TRUE(std::filesystem::exists(file)) << file;
  }
  EXPECT_THROW((void)make_protocol("hughes_lu", {}), std::invalid_argument);
}

TEST(Registry, UnknownProtocolSuggestsTheNearest) {
  try {
    (void)scene::protocol_traits("hughes_lu");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("hughes_liu"));
  }
}

TEST(Registry, MissingCapabilityIsRefusedByName) {
  Pair pair;
  std::vector<PeerDescription> descriptions = {pair.explicit_side.description(), pair.implicit_side.description()};
  EXPECT_NO_THROW(check_capabilities(scene::protocol_traits("hughes_liu"), descriptions));
  try {
    check_capabilities(scene::protocol_traits("kim"), descriptions);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'explicit'"), testing::HasSubstr("repeat_window")));
  }
  descriptions.pop_back();
  EXPECT_THROW(check_capabilities(scene::protocol_traits("hughes_liu"), descriptions), ConfigError);
}

TEST(Link, WrongNumberOfRowsIsAProtocolError) {
  Pair pair;
  auto coupling = pair.coupling(0.1);
  wire::Message wrong;
  wrong.make<wire::Advanced>().increment = {2, 1, {0.0, 0.0}};
  Peer peer{"explicit", [](wire::Message&) {}, [&wrong]() -> wire::Message& { return wrong; }};
  Link link(peer, pair.explicit_side.description(), InterfaceRows{{0}, 1});
  link.post_advance(Step{}, {0.0}, Acceptance::at_once);
  EXPECT_THROW(link.wait_advanced(), ProtocolError);
  wrong.make<wire::Accepted>();
  link.post_advance(Step{}, {0.0}, Acceptance::at_once);
  EXPECT_THROW(link.wait_advanced(), ProtocolError);
}

}  // namespace
}  // namespace ricochet::coupler::test
