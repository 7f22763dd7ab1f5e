#include "coupler/protocols/unit_response.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"
#include "coupler/interface/vectors.hpp"

namespace ricochet::coupler {
namespace {

constexpr double symmetry_tolerance = 1e-6;

void require_symmetric(const std::string& participant, const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return;
  const double largest = matrix.cwiseAbs().maxCoeff();
  const double difference = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  if (difference <= symmetry_tolerance * largest) return;
  throw ConfigError(fmt::format(
      "participant '{}' answers unit link inputs with a matrix that is not symmetric (by {:.3g} of its largest entry): "
      "it is not linear, or a repeated window does not start from the same state; use the protocol fixed_point for it",
      participant, difference / largest));
}

}  // namespace

Eigen::MatrixXd unit_response(Link& link, Response response, const Step& step, const std::vector<double>& probes) {
  const auto answer_to = [&](const std::vector<double>& input) -> Eigen::VectorXd {
    link.post_advance(step, input, Acceptance::trial);
    link.wait_advanced();
    return view(response == Response::velocity ? link.velocity_m_s() : link.output());
  };
  const std::vector<double> base_input = link.input();
  const Eigen::VectorXd base = answer_to(base_input);
  Eigen::MatrixXd matrix(base.size(), base.size());
  for (std::size_t j = 0; j < base_input.size(); ++j) {
    std::vector<double> input = base_input;
    input[j] += probes[j];
    matrix.col(static_cast<Eigen::Index>(j)) = (answer_to(input) - base) / probes[j];
  }
  require_symmetric(link.name(), matrix);
  return 0.5 * (matrix + matrix.transpose());
}

}  // namespace ricochet::coupler
