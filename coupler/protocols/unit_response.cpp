#include "coupler/protocols/unit_response.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "coupler/interface/vectors.hpp"
#include "coupler/protocols/probe_groups.hpp"

namespace ricochet::coupler {
namespace {

/// A share of the largest answer: rounding is far below, what is not linear far above.
constexpr double tolerance = 1e-6;

void require_symmetric(const std::string& participant, const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return;
  const double largest = matrix.cwiseAbs().maxCoeff();
  const double difference = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  if (difference <= tolerance * largest) return;
  throw ConfigError(fmt::format(
      "participant '{}' answers unit link inputs with a matrix that is not symmetric (by {:.3g} of its largest entry), "
      "linear as it is: its rows are not its nodes, or its elements are not elastic; use the protocol fixed_point for "
      "it",
      participant, difference / largest));
}

/// Names the row whose answer is furthest from the expected one.
void require_same(const Link& link, const Eigen::VectorXd& found, const Eigen::VectorXd& expected, double scale,
                  const std::string& what, const std::string& allowed) {
  if (found.size() == 0) return;
  Eigen::Index row = 0;
  if ((found - expected).cwiseAbs().maxCoeff(&row) <= tolerance * scale) return;
  const int components = link.rows().components();
  throw ConfigError(
      fmt::format("participant '{}', interface node {}, component {}: {}: found a change of {:.6g}, "
                  "expected {:.6g}; allowed: {}",
                  link.name(), row / components, row % components, what, found[row], expected[row], allowed));
}

Eigen::MatrixXd response_one_by_one(const std::vector<double>& probes, const ChangeOfAnswer& answer) {
  const auto size = static_cast<Eigen::Index>(probes.size());
  Eigen::MatrixXd matrix(size, size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const double probe = probes[static_cast<std::size_t>(j)];
    matrix.col(j) = answer(probe * Eigen::VectorXd::Unit(size, j)) / probe;
  }
  return matrix;
}

}  // namespace

std::string linear_bodies_are_needed(bool implicit) {
  return std::string(
             "under this protocol, which takes the answer of the start for the whole run, linear bodies; any "
             "body under hughes_liu, kim, kim_predicted and fixed_point, and ") +
         (implicit ? "an implicit one under belytschko_mullen and prakash_hjelmstad, too"
                   : "under prakash_hjelmstad and gravouil_combescure with coupling.substeps = 1");
}

Eigen::VectorXd trial_answer(Link& link, Response response, const Step& step, const std::vector<double>& input) {
  link.post_advance(step, input, Acceptance::trial);
  link.wait_advanced();
  return view(response == Response::velocity ? link.velocity_m_s() : link.output());
}

Eigen::MatrixXd unit_response(Link& link, Response response, const Step& step, const std::vector<double>& probes) {
  const auto answer_to = [&](const std::vector<double>& input) { return trial_answer(link, response, step, input); };
  const std::vector<double> base_input = link.input();
  const Eigen::VectorXd base = answer_to(base_input);
  const auto change_of_answer = [&](const Eigen::VectorXd& change) -> Eigen::VectorXd {
    return answer_to(to_vector(view(base_input) + change)) - base;
  };
  const auto grouped = response_by_groups(link, probes, change_of_answer);
  const Eigen::MatrixXd matrix = grouped ? *grouped : response_one_by_one(probes, change_of_answer);
  // All inputs at once, of another size and sign.
  Eigen::VectorXd change = -2.0 * view(probes);
  for (Eigen::Index j = 1; j < change.size(); j += 2) change[j] *= 0.75;
  const Eigen::VectorXd expected = matrix * change, found = change_of_answer(change),
                        again = answer_to(base_input) - base;
  const double scale = change.size() > 0 ? expected.cwiseAbs().maxCoeff() : 0.0;
  require_same(link, again, Eigen::VectorXd::Zero(again.size()), scale,
               "it does not answer the same link input alike, tried again after others",
               "a repeated window that starts from the accepted state");
  require_same(link, found, expected, scale, "it does not answer its link input linearly",
               linear_bodies_are_needed(link.implicit()));
  require_symmetric(link.name(), matrix);
  return 0.5 * (matrix + matrix.transpose());
}

}  // namespace ricochet::coupler
