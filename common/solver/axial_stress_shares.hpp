#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/fem/axial_stress.hpp"

namespace ricochet::solver {

/// A participant's share of the mean axial stress in the layers of its bodies, for output.axial_stress_every of the
/// scene: its share of the layer's mean axial stress [Pa], tension positive, for each layer in which it has elements.
class AxialStressShares {
 public:
  /// Most layers of one body.
  static constexpr int most_layers = 100;

  AxialStressShares() = default;  ///< of no layer
  /// The columns of no layer, too, if the scene does not ask. `states`: as they will be given to `append`.
  AxialStressShares(const scene::Problem& problem, const std::vector<BodyState>& states);

  /// See participant::Description::axial_stress_columns.
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  /// Throws as `require_finite` does. `window`: for the error text.
  void append(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row);

 private:
  struct Body {
    fem::SparseMatrix shares;  ///< layers with own elements x dofs
    Eigen::VectorXd stress;
    fem::SparseMatrix element_shares{};  ///< of a part that yields: the same layers x elements
  };
  void add_body(const scene::Problem& problem, const BodyState& state);

  std::vector<std::string> columns_;
  std::vector<Body> bodies_;
};

}  // namespace ricochet::solver
