#include "coupler/protocols/unit_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

constexpr double symmetry_tolerance = 1e-6;

void require_symmetric(const std::string& participant, const std::vector<double>& matrix, std::size_t size) {
  double largest = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      difference = std::max(difference, std::abs(matrix[i * size + j] - matrix[j * size + i]));
    }
    for (std::size_t j = 0; j < size; ++j) largest = std::max(largest, std::abs(matrix[i * size + j]));
  }
  if (difference <= symmetry_tolerance * largest) return;
  throw ConfigError(fmt::format(
      "participant '{}' answers unit link inputs with a matrix that is not symmetric (by {:.3g} of its largest entry): "
      "it is not linear, or a repeated window does not start from the same state; use the protocol fixed_point for it",
      participant, difference / largest));
}

}  // namespace

std::vector<double> unit_response(Link& link, Response response, const Step& step, const std::vector<double>& probes) {
  const auto answer_to = [&](const std::vector<double>& input) {
    link.post_advance(step, input, Acceptance::trial);
    link.wait_advanced();
    return response == Response::velocity ? link.velocity_m_s() : link.output();
  };
  const std::vector<double> base_input = link.input(), base = answer_to(base_input);
  const std::size_t size = base_input.size();
  std::vector<double> matrix(size * size);
  for (std::size_t j = 0; j < size; ++j) {
    std::vector<double> input = base_input;
    input[j] += probes[j];
    const auto answer = answer_to(input);
    for (std::size_t i = 0; i < size; ++i) matrix[i * size + j] = (answer[i] - base[i]) / probes[j];
  }
  require_symmetric(link.name(), matrix, size);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      matrix[i * size + j] = matrix[j * size + i] = 0.5 * (matrix[i * size + j] + matrix[j * size + i]);
    }
  }
  return matrix;
}

}  // namespace ricochet::coupler
