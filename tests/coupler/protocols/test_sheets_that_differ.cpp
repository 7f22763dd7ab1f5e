// Sheets of springs whose nodes at the interface differ: an explicit sheet of five rows whose ends follow an implicit
// one of three by interpolation, u_E = Pi u. Protocols see the shared nodes alone and know nothing of it.
#include <gtest/gtest.h>

#include <cmath>

#include "coupler/protocols/protocol.hpp"
#include "tests/coupler/protocols/spring_chain.hpp"

namespace ricochet::coupler::test {
namespace {

using Eigen::VectorXd;

constexpr int columns = 4, fine_rows = 5, coarse_rows = 3;

/// `rows` strings of springs side by side, one apart in x, which share a stiffness and a mass per width; springs across
/// tie them. Node (row, column) is row * columns + column; the sheet is 1 wide.
Chain sheet(int rows, double stiffness, double mass, double start) {
  const Eigen::Index nodes = rows * columns;
  Chain chain{VectorXd::Zero(nodes), Eigen::MatrixXd::Zero(nodes, nodes), VectorXd::Zero(nodes)};
  const auto spring = [&](int a, int b, double k) {
    chain.stiffness(a, a) += k;
    chain.stiffness(b, b) += k;
    chain.stiffness(a, b) -= k;
    chain.stiffness(b, a) -= k;
  };
  for (int row = 0; row < rows; ++row) {
    const double width = (row == 0 || row == rows - 1 ? 0.5 : 1.0) / (rows - 1);
    for (int column = 0; column < columns; ++column) {
      const int node = row * columns + column;
      const double length = column == 0 || column == columns - 1 ? 0.5 : 1.0;
      chain.mass[node] = mass * width * length;
      chain.position[node] = start + column + 100.0 * row;  // apart from all others
      if (column + 1 < columns) spring(node, node + 1, stiffness * width);
      if (row + 1 < rows) spring(node, node + columns, stiffness * length * (rows - 1));
    }
  }
  return chain;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> halves() {
  Eigen::MatrixXd pi(fine_rows, coarse_rows);
  pi << 1.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0;
  return pi.sparseView();
}

std::vector<int> column_of(int rows, int column) {
  std::vector<int> nodes;
  for (int row = 0; row < rows; ++row) nodes.push_back(row * columns + column);
  return nodes;
}

VectorXd at(const VectorXd& values, const std::vector<int>& nodes) { return values(nodes); }

double critical_step(const Chain& chain) {
  const Eigen::MatrixXd mass = chain.mass.asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(chain.stiffness, mass);
  return 2.0 / std::sqrt(modes.eigenvalues().maxCoeff());
}

/// The explicit sheet's last column is the implicit one's first.
struct Sheets {
  Sheets(const std::string& name, double step_of_critical, int substeps = 1)
      : explicit_side("explicit", false, fine, column_of(fine_rows, columns - 1), wave(fine_rows)),
        implicit_side("implicit", true, coarse, column_of(coarse_rows, 0), wave(coarse_rows)) {
    const double dt = substeps * step_of_critical * critical_step(fine);
    ProtocolSettings settings;
    settings.substeps = substeps;
    protocol = make_protocol(name, settings);
    const std::vector<PeerDescription> descriptions{explicit_side.description(), implicit_side.description()};
    InterfaceMap map(descriptions, {InterfaceRows::of_operator(halves(), 1), InterfaceRows({0, 1, 2}, 1)});
    coupling = std::make_unique<Coupling>(std::vector<Peer>{explicit_side.peer(), implicit_side.peer()}, descriptions,
                                          std::move(map), dt);
    request.window_size_s = dt;
    request.substeps = substeps;
  }
  /// Even along the interface, so that both sides begin with one velocity there.
  static VectorXd wave(int rows) {
    VectorXd v(rows * columns);
    for (int i = 0; i < v.size(); ++i) {
      const int column = i % columns;
      v[i] = 0.3 + (column > 0 && column < columns - 1 ? std::cos(1.0 + i) : 0.0);
    }
    return v;
  }
  void start() { protocol->start(*coupling, request); }
  void step() { protocol->step(*coupling, Step{.accepted_window = window, .absolute = window % 7 == 0}), ++window; }
  [[nodiscard]] double momentum() const { return explicit_side.momentum() + implicit_side.momentum(); }
  [[nodiscard]] double energy() const { return explicit_side.energy() + implicit_side.energy(); }

  Chain fine = sheet(fine_rows, 1.0, 1.0, 0.0), coarse = sheet(coarse_rows, 20.0, 1.0, 3.0);
  FakeParticipant explicit_side, implicit_side;
  std::unique_ptr<Protocol> protocol;
  std::unique_ptr<Coupling> coupling;
  wire::Initialize request;
  std::int64_t window = 0;
};

class SheetsThatDiffer : public testing::TestWithParam<std::pair<const char*, int>> {};

TEST_P(SheetsThatDiffer, KeepMomentumAndOneMotionAndStayBounded) {
  const std::string protocol = GetParam().first;
  Sheets run(protocol, 0.7, GetParam().second);
  run.start();
  const bool dual = protocol == "prakash_hjelmstad" || protocol == "gravouil_combescure";
  const double momentum = run.momentum(), energy = run.energy();
  for (int n = 0; n < 2000; ++n) {
    run.step();
    ASSERT_LT(std::abs(run.energy() / energy - 1.0), 0.6)
        << n << ": this metric swings at short waves, growth would pass any bound";
    if (protocol == "hughes_liu") continue;  // it shows the explicit side the predictor
    const auto& values = dual ? &FakeParticipant::v : &FakeParticipant::u;
    const VectorXd followed = halves() * at(run.implicit_side.*values, column_of(coarse_rows, 0));
    const VectorXd own = at(run.explicit_side.*values, column_of(fine_rows, columns - 1));
    ASSERT_LT((own - followed).norm(), 1e-9 * (1.0 + own.norm())) << n;
  }
  if (protocol != "kim") {
    EXPECT_NEAR(run.momentum() / momentum, 1.0, 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(Protocols, SheetsThatDiffer,
                         testing::Values(std::pair{"hughes_liu", 1}, std::pair{"kim", 1},
                                         std::pair{"belytschko_mullen", 1}, std::pair{"prakash_hjelmstad", 1},
                                         std::pair{"prakash_hjelmstad", 3}, std::pair{"gravouil_combescure", 1},
                                         std::pair{"fixed_point", 1}),
                         [](const auto& info) {
                           return std::string(info.param.first) + "_" + std::to_string(info.param.second);
                         });

/// Both sheets stretched evenly, with one force per width: nothing accelerates at the interface.
TEST(SheetsThatDiffer, PassOnAConstantForcePerWidth) {
  Sheets run("hughes_liu", 0.5);
  for (auto* side : {&run.explicit_side, &run.implicit_side}) {
    side->v.setZero();
    for (Eigen::Index i = 0; i < side->u.size(); ++i) {
      const auto column = static_cast<double>(i % columns);
      side->u[i] = side == &run.explicit_side ? 1e-3 * (column - (columns - 1)) : 1e-3 / 20.0 * column;
    }
  }
  run.start();
  EXPECT_LT(at(run.implicit_side.a, column_of(coarse_rows, 0)).norm(), 1e-14);
  EXPECT_GT(run.implicit_side.a.norm(), 1e-4) << "its other end does";
}

TEST(InterfaceRows, RefuseAnOperatorThatMovesWhatIsCarriedAlong) {
  Eigen::SparseMatrix<double, Eigen::RowMajor> pi = halves();
  pi.coeffRef(1, 0) = 0.6;
  EXPECT_THROW((void)InterfaceRows::of_operator(pi, 1), std::invalid_argument);
}

/// What picks nodes does the same by a matrix of zeros and ones.
TEST(InterfaceRows, ThatPickAreAnOperatorOfOnes) {
  const InterfaceRows picks({2, 0}, 2);
  Eigen::MatrixXd ones = Eigen::MatrixXd::Zero(2, 3);
  ones(0, 2) = ones(1, 0) = 1.0;
  const InterfaceRows multiplies = InterfaceRows::of_operator(ones.sparseView(), 2);
  const std::vector<double> shared{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, own{7.0, 8.0, 9.0, 10.0};
  std::vector<double> first, second;
  picks.gather(shared, first);
  multiplies.gather(shared, second);
  EXPECT_EQ(first, second);
  first = second = shared;
  picks.add(own, first);
  multiplies.add(own, second);
  EXPECT_EQ(first, second);
  EXPECT_EQ(picks.per_node({1.0, 2.0, 3.0}), multiplies.per_node({1.0, 2.0, 3.0}));
  const Eigen::MatrixXd own_matrix = Eigen::MatrixXd::Random(4, 4);
  Eigen::MatrixXd first_matrix = Eigen::MatrixXd::Zero(6, 6), second_matrix = first_matrix;
  picks.add_matrix(own_matrix, first_matrix);
  multiplies.add_matrix(own_matrix, second_matrix);
  EXPECT_TRUE(first_matrix == second_matrix);
}

}  // namespace
}  // namespace ricochet::coupler::test
