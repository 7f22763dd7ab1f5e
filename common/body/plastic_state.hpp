#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/base/archive.hpp"
#include "common/body/blocks.hpp"
#include "common/fem/part.hpp"

namespace ricochet::solver {

/// Memory of the elements of a part that yields, of an accepted window. Plastic strain is kept at the quadrature
/// points (fem::ElementPoint), element by element, as the components of fem::StressVector with each shear times
/// sqrt(2), so that e : e is a sum of squares. It takes `modulus_pa` times itself off the elastic stress: the modulus
/// is E of bars, whose lateral stress is zero, else 2 G, since plastic strain has no trace. Where materials differ each
/// element has that of its own.
struct PlasticState {
  PlasticState() = default;
  explicit PlasticState(const fem::Part& part);

  int components = 1, points = 1;  ///< of a strain; of an element
  std::vector<double> moduli_pa;   ///< by 1 + fem::material_index
  std::vector<int> modulus;        ///< per element: which of them; empty: the first
  Eigen::VectorXd strain;          ///< plastic, `components` per point
  Eigen::VectorXd temperature_k;   ///< per point; of a material whose plastic work heats it, else empty
  Eigen::VectorXd equivalent;      ///< per point: equivalent plastic strain, the integral of sqrt(2/3 de : de)
  Eigen::VectorXd force_n;   ///< per degree of freedom: integral of B^T modulus strain dV, so that P = K u - force
  Eigen::VectorXd energy_j;  ///< per block of nodes: integral of modulus/2 strain : strain dV of its elements
  Eigen::VectorXd work_j;    ///< the same: plastic work so far
  double largest = 0.0;      ///< of `equivalent`
  double hottest_k = 0.0;    ///< largest of `temperature_k`

  /// An element is of the block of its first node.
  [[nodiscard]] static int block_of(const fem::Part& part, int element) {
    return part.mesh.elements[fem::at(element)][0] / block_nodes;
  }
  /// Energy that the elements of a block store beyond u . P/2 of its nodes [J].
  [[nodiscard]] double stored_beyond_j(const Eigen::VectorXd& u, int block, int rows_of_node) const;
  [[nodiscard]] auto at(Eigen::Index point) { return strain.segment(point * components, components); }
  [[nodiscard]] auto at(Eigen::Index point) const { return strain.segment(point * components, components); }
  /// In the middle of an element, the mean of its points: plastic strain as a tensor in the order of fem::StressVector,
  /// what it takes off the stress [Pa], equivalent plastic strain and temperature.
  [[nodiscard]] fem::StressVector strain_of(int element) const;
  [[nodiscard]] fem::StressVector stress_of(int element) const { return modulus_pa(element) * strain_of(element); }
  [[nodiscard]] double modulus_pa(int element) const {
    return moduli_pa[modulus.empty() ? 0 : fem::at(modulus[fem::at(element)])];
  }
  [[nodiscard]] double equivalent_of(int element) const { return mean_of(equivalent, element); }
  [[nodiscard]] double temperature_of(int element) const { return mean_of(temperature_k, element); }
  [[nodiscard]] bool heats() const { return temperature_k.size() > 0; }

  /// All that an element remembers, as numbers: appended, and taken from where they begin. Returns where they end.
  [[nodiscard]] int numbers_of_element() const { return points * (components + (heats() ? 2 : 1)); }
  void append_element(int element, std::vector<double>& numbers) const;
  const double* take_element(int element, const double* numbers);

  void archive(Archive& a) {
    a.same_size(strain, equivalent, temperature_k, force_n, energy_j, work_j);
    a(largest, hottest_k);
  }

 private:
  /// visit(its numbers, so many) of each kind.
  template <class State, class Visit>
  static void visit_element(State& state, int element, const Visit& visit) {
    const Eigen::Index first = Eigen::Index{element} * state.points;
    visit(state.strain.data() + first * state.components, state.points * state.components);
    visit(state.equivalent.data() + first, state.points);
    if (state.heats()) visit(state.temperature_k.data() + first, state.points);
  }
  void set_temperature(const fem::Part& part, double elsewhere_k);
  [[nodiscard]] double mean_of(const Eigen::VectorXd& of_points, int element) const {
    return of_points.segment(Eigen::Index{element} * points, points).mean();
  }
};

}  // namespace ricochet::solver
