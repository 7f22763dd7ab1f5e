#include "coupler/contract/contract_response.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

/// More unit inputs than this are not tried: evenly spaced ones are.
constexpr std::size_t most_probes = 40;
/// Those rows of the link that are tried one by one.
std::vector<std::size_t> probed_rows(std::size_t size) {
  std::vector<std::size_t> rows;
  const std::size_t count = std::min(size, most_probes);
  for (std::size_t i = 0; i < count; ++i) rows.push_back(i * size / count);
  return rows;
}

/// Unit responses of some rows, and what another input shows of them.
struct UnitResponses {
  Eigen::MatrixXd matrix;
  double nonlinear = 0.0;  ///< change by all inputs at once, twice as large and turned round: off by so much of it
};

/// Looks at a matrix that should be one of unit responses. Returns what is worth saying of a body that is not linear.
std::string check_symmetry(const ContractRun& run, const std::vector<std::size_t>& rows, const UnitResponses& responses,
                           const std::string& answer, const std::string& sign) {
  const auto& matrix = responses.matrix;
  const double size = matrix.cwiseAbs().maxCoeff();
  if (!(size > 0.0)) fail(fmt::format("{} does not depend on its link input", answer));
  Eigen::Index i = 0, j = 0;
  const double skew = (matrix - matrix.transpose()).cwiseAbs().maxCoeff(&i, &j);
  const bool linear = responses.nonlinear <= rounding;
  const auto not_linear = fmt::format(
      "{} is not linear, by {:.2g} where the input is turned round and doubled{}", answer, responses.nonlinear,
      run.implicit() ? "" : ": belytschko_mullen and dual protocols with substeps > 1 will refuse it");
  if (skew > rounding * size && !linear) throw NotApplicable{not_linear};
  if (skew > rounding * size) {
    const auto at = [&](Eigen::Index k) { return place(run, rows[static_cast<std::size_t>(k)]); };
    fail(
        fmt::format("{} at {} is {:.6g} for a unit input at {}, and {:.6g} the other way round, expected the same: its "
                    "rows are in another order than the nodes that it describes (reversed, or by component in place of "
                    "by node)",
                    answer, at(i), matrix(i, j), at(j), matrix(j, i)));
  }
  if (matrix.diagonal().maxCoeff() <= 0.0) fail(fmt::format("{} has the wrong sign: {}", answer, sign));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(matrix, Eigen::EigenvaluesOnly);
  if (modes.eigenvalues()[0] < -rounding * size)
    fail(fmt::format("{} is not positive: some input meets a resistance of {:.3g}, in units of the largest entry, {}",
                     answer, modes.eigenvalues()[0] / size, sign));
  return linear ? "" : not_linear;
}

std::string probes_text(std::size_t probed, std::size_t size) {
  return probed == size ? "" : fmt::format("{} of {} unit inputs tried", probed, size);
}

std::string joined_texts(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

/// Column by column, of some rows, what `answer(input)` changes by.
template <class Answer>
UnitResponses unit_responses(const ContractRun& run, const std::vector<std::size_t>& rows, const Answer& answer) {
  const Values zero(run.size(), 0.0);
  const Values before = answer(zero);
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd matrix(count, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    Values input = zero;
    const auto row = rows[static_cast<std::size_t>(j)];
    input[row] = probe_size(run, row);
    const Values after = answer(input);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto to = rows[static_cast<std::size_t>(i)];
      matrix(i, j) = (after[to] - before[to]) / input[row];
    }
  }
  Values all = zero;
  for (const auto row : rows) all[row] = -2.0 * probe_size(run, row);
  const Values after = answer(all);
  Eigen::VectorXd found(count), probes(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto row = rows[static_cast<std::size_t>(i)];
    found[i] = after[row] - before[row];
    probes[i] = all[row];
  }
  const Eigen::VectorXd expected = matrix * probes;
  const double scale =
      std::max(expected.cwiseAbs().maxCoeff(), matrix.cwiseAbs().maxCoeff() * probes.cwiseAbs().maxCoeff());
  return {matrix, scale > 0.0 ? (found - expected).cwiseAbs().maxCoeff() / scale : 0.0};
}

ContractDrive forced(ContractDrive drive) {
  drive.by_force = true;
  return drive;
}

/// Where force drives, the acceleration at the present time is M^-1 times it, which is symmetric whatever the
/// masses only if rows are nodes.
std::string accelerate_as_pushed(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first) {
  const auto rows = probed_rows(first.size());
  if (rows.empty()) return "";
  ContractPeer peer(command);
  ContractRun run;
  describe(peer, command.timeout_s, run);
  start(peer, drive, run);
  const auto integration = run.implicit() ? Integration::implicit_newmark : Integration::explicit_central;
  const double sign = run.implicit() ? -1.0 : 1.0;
  const auto mobility = unit_responses(run, rows, [&](const Values& input) {
    Values rate = synchronise(peer, run, input, integration).acceleration;
    for (double& value : rate) value *= sign;
    return rate;
  });
  return joined_texts(
      check_symmetry(run, rows, mobility, run.implicit() ? "minus its acceleration" : "its acceleration",
                     run.implicit() ? "the link input L acts with a minus, M a = f - K u - L"
                                    : "driven by force, M a = f - K u + lambda, lambda the link input"),
      probes_text(rows.size(), first.size()));
}

/// Names the first window, row and quantity in which b differs from a by more than this share of its largest; window n
/// of a is n times `stride` of b.
void require_same_motion(const ContractRun& a, const ContractRun& b, int stride, const std::string& what,
                         double share = rounding) {
  struct Quantity {
    const char *name, *unit;
    const Values &in_a, &in_b;
  };
  const auto size = a.size();
  for (const auto& q :
       {Quantity{"displacement", "m", a.output, b.output}, Quantity{"velocity", "m/s", a.velocity, b.velocity},
        Quantity{"acceleration", "m/s^2", a.acceleration, b.acceleration}}) {
    const double scale = largest(q.in_b);
    for (std::size_t k = 0; k < q.in_a.size(); ++k) {
      const std::size_t window = k / size, row = k % size;
      const double other = q.in_b[window * static_cast<std::size_t>(stride) * size + row];
      if (std::abs(q.in_a[k] - other) <= share * scale) continue;
      fail(fmt::format("window {}, {}: {} is {:.6g} {}, {} {:.6g} {}", window, place(a, row), q.name, q.in_a[k], q.unit,
                       what, other, q.unit));
    }
  }
}

}  // namespace

std::string respond_like_an_elastic_body(const ContractCommand& command, const ContractDrive& drive,
                                         const ContractRun& first) {
  if (first.size() == 0) throw NotApplicable{"it has no interface nodes"};
  if (first.implicit()) return accelerate_as_pushed(command, drive, first);
  const auto rows = probed_rows(first.size());
  ContractPeer peer(command);
  ContractRun run;
  describe(peer, command.timeout_s, run);
  start(peer, drive, run);
  const auto stiffness = unit_responses(run, rows, [&](const Values& input) {
    return synchronise(peer, run, input, Integration::explicit_central).output;
  });
  return joined_texts(check_symmetry(run, rows, stiffness, "its internal force",
                                     "P = K u is positive where it resists a positive displacement"),
                      probes_text(rows.size(), first.size()));
}

std::string take_substeps(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first) {
  require_role(first, Role::explicit_solver);
  require_capability(first, Capability::driven_by_force, "dual protocols will refuse it");
  accelerate_as_pushed(command, forced(drive), first);
  for (const int m : {1, 2, 4}) {
    ContractDrive coarse = forced(drive), fine = forced(drive);
    coarse.substeps = fine.fine = m;
    fine.windows = m * coarse.windows;
    fine.window_size_s = first.window_size_s;
    coarse.window_size_s = m * first.window_size_s;
    ContractRun whole, steps;
    run_contract(command, coarse, whole);
    if (m == 1) continue;  // there is nothing to compare it with but that it comes to its end
    run_contract(command, fine, steps);
    require_same_motion(
        whole, steps, m,
        fmt::format("driven by force with m = {} steps in a window; after {} windows of one step", m, m));
  }
  return "m = 1, 2, 4";
}

std::string take_single_substeps(const ContractCommand& command, const ContractDrive& drive, const ContractRun& first) {
  require_role(first, Role::explicit_solver);
  require_capability(first, Capability::single_substep, "protocol gravouil_combescure will refuse it");
  ContractDrive whole = forced(drive);
  whole.substeps = 3;
  whole.window_size_s = 3.0 * first.window_size_s;
  ContractDrive single = whole;
  single.one_by_one = true;
  ContractRun at_once, one_by_one;
  run_contract(command, whole, at_once);
  run_contract(command, single, one_by_one);
  require_same_motion(one_by_one, at_once, 1, "asked for one substep after the other; asked for the whole window");
  return "";
}

std::string take_interface_stiffness(const ContractCommand& command, const ContractDrive& drive,
                                     const ContractRun& first) {
  require_role(first, Role::implicit_solver);
  require_capability(first, Capability::interface_stiffness, "dual protocols and belytschko_mullen will refuse it");
  const std::size_t size = first.size(), components = static_cast<std::size_t>(first.description.components);
  if (size == 0) throw NotApplicable{"it has no interface nodes"};
  ContractDrive stiff = drive;
  stiff.interface_stiffness.assign(size * size, 0.0);
  for (std::size_t i = 0; i < size; ++i) {
    const double k = first.description.interface_mass_kg.data[i / components] / std::pow(first.window_size_s, 2);
    stiff.interface_stiffness[i * size + i] = 2.0 * k;
    if (i + components >= size) continue;  // and between neighbours
    stiff.interface_stiffness[i * size + i + components] = stiff.interface_stiffness[(i + components) * size + i] =
        0.1 * k;
  }
  ContractRun with;
  run_contract(command, stiff, with);
  ContractDrive plain = drive;
  plain.inputs = with.input;
  for (std::size_t k = 0; k < plain.inputs.size(); ++k) {
    for (std::size_t j = 0; j < size; ++j)
      plain.inputs[k] += stiff.interface_stiffness[k % size * size + j] * with.output[k / size * size + j];
  }
  ContractRun without;
  run_contract(command, plain, without);
  const bool linear = first.description.has(Capability::load_state);
  require_same_motion(with, without, 1, "with a stiffness S on the interface; given the force S u itself",
                      linear ? rounding : solved);
  return "";
}

}  // namespace ricochet::coupler
