#include "common/cost/machine_speed.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <vector>

#include "common/base/parallel.hpp"
#include "common/cost/predicted_cost.hpp"
#include "common/fem/stiffness_product.hpp"

namespace ricochet::cost {
namespace {

/// K u of the patch of measure_speed on the machine on which docs/speed.md was measured [s].
constexpr double reference_product_s = 6.0e-6;

/// The shortest time of as many tries as some milliseconds allow, five at least.
template <class Work>
double least_time_s(const Work& work) {
  constexpr double enough_s = 3e-3;
  double least = std::numeric_limits<double>::infinity(), sum = 0.0;
  for (int tries = 0; tries < 5 || sum < enough_s; ++tries) {
    const auto start = std::chrono::steady_clock::now();
    work();
    const double time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    least = std::min(least, time_s);
    sum += time_s;
  }
  return least;
}

}  // namespace

double time_product(const fem::Part& part) {
  const fem::StiffnessProduct product(part.stiffness, fem::components(part.mesh.model));
  const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(part.dofs(), 0.0, 1.0);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(part.dofs());
  return least_time_s([&] { product.multiply(u, force); });
}

double memory_read_s() {
  constexpr Eigen::Index more_than_caches = 16'000'000;  // 128 MB
  static const double of_number_s = [] {
    const Eigen::VectorXd numbers = Eigen::VectorXd::Ones(more_than_caches);
    double sum = 0.0;
    const double all_s = least_time_s([&] { sum += numbers.sum(); });
    return sum > 0.0 ? all_s / static_cast<double>(more_than_caches) : 0.0;  // the sum is to be computed
  }();
  return of_number_s;
}

MachineSpeed measure_speed() {
  std::vector<double> lines;
  for (int i = 0; i <= 40; ++i) lines.push_back(1e-3 * i);
  const fem::Mesh mesh = fem::quadrilateral_mesh(fem::Model::plane_strain, lines, lines);
  std::vector<int> elements;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) elements.push_back(e);
  fem::Section section;
  section.model = fem::Model::plane_strain;
  const fem::Part patch = fem::extract_part(mesh, "patch", section, {2e11, 0.3, 7800.0}, elements);
  return {time_product(patch) / reference_product_s, usable_processors()};
}

}  // namespace ricochet::cost
