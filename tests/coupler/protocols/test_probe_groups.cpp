// The interface operator of an explicit side, found by pushing many nodes at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "coupler/protocols/unit_response.hpp"
#include "tests/coupler/protocols/spring_chain.hpp"

namespace ricochet::coupler::test {
namespace {

constexpr int nodes = 200, substeps = 3;
constexpr double window_s = 1.2;

Chain uneven_chain() {
  std::vector<double> springs, masses;
  for (int i = 0; i + 1 < nodes; ++i) {
    springs.push_back(1.0 + 0.3 * std::sin(7.0 * i));
    masses.push_back(1.0 + 0.2 * std::cos(3.0 * i));
  }
  return Chain::of(springs, masses, 0.0);
}

/// Velocity after the window per unit of force that has grown linearly over it, node by node.
Eigen::MatrixXd exact_response(const Chain& chain) {
  const double h = window_s / substeps;
  Eigen::MatrixXd response(nodes, nodes);
  for (int node = 0; node < nodes; ++node) {
    Eigen::VectorXd u = Eigen::VectorXd::Zero(nodes), v = u, a = u;
    for (int j = 1; j <= substeps; ++j) {
      u += h * v + 0.5 * h * h * a;
      const Eigen::VectorXd force =
          Eigen::VectorXd::Unit(nodes, node) * (static_cast<double>(j) / substeps) - chain.stiffness * u;
      const Eigen::VectorXd next = force.cwiseQuotient(chain.mass);
      v += 0.5 * h * (a + next);
      a = next;
    }
    response.col(node) = v;
  }
  return response;
}

struct Probed {
  Eigen::MatrixXd response;
  long trials = 0;
};

/// Every node of the chain is shared, and it moves while it is probed.
Probed probed(const Chain& chain) {
  std::vector<int> shared(nodes);
  std::iota(shared.begin(), shared.end(), 0);
  FakeParticipant left("explicit", false, chain, shared, Eigen::VectorXd::LinSpaced(nodes, -1.0, 2.0)),
      right("implicit", true, chain, shared, Eigen::VectorXd::Zero(nodes));
  auto coupling = unstarted({&left, &right}, window_s);
  wire::Initialize request;
  request.window_size_s = window_s;
  request.substeps = substeps;
  request.driven_by = name_of(Drive::force);
  coupling->initialize_explicit(request, Masses::own);
  Link& link = coupling->links().front();
  link.post_synchronise(Integration::explicit_central, std::vector<double>(nodes, 0.0));
  link.wait_synchronised();
  const Eigen::MatrixXd response = unit_response(link, Response::velocity, Step{}, std::vector<double>(nodes, 1.0));
  return {response, std::count(left.asked.begin(), left.asked.end(), "advance")};
}

TEST(ProbeGroups, TakeTensOfTrialsForHundredsOfNodesAndGiveTheSameOperator) {
  const Chain chain = uneven_chain();
  const Probed found = probed(chain);
  EXPECT_LT((found.response - exact_response(chain)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LE(found.trials, 20) << "6 samples, groups of nodes more than twice the reach apart, and 4 to compare";
}

// Neighbours of the chain lie anywhere, so that a push reaches all of the interface.
TEST(ProbeGroups, LeaveNodesOneByOneWhereAPushReachesFar) {
  Chain chain = uneven_chain();
  for (int i = 0; i < nodes; ++i) chain.position[i] = (73 * i) % nodes;
  const Probed found = probed(chain);
  EXPECT_LT((found.response - exact_response(chain)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_GT(found.trials, nodes);
}

// One spring in the middle of soft neighbours that are close together carries a push across more of them than the
// samples see: found out, and every node is probed by itself.
TEST(ProbeGroups, AreGivenUpWhereOneNodeReachesFurtherThanTheSamples) {
  Chain chain = uneven_chain();
  chain.stiffness(40, 60) = chain.stiffness(60, 40) = -0.5;
  chain.stiffness(40, 40) += 0.5;
  chain.stiffness(60, 60) += 0.5;
  const Probed found = probed(chain);
  EXPECT_LT((found.response - exact_response(chain)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_GT(found.trials, nodes);
}

}  // namespace
}  // namespace ricochet::coupler::test
