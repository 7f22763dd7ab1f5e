#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "common/fem/axial_stress.hpp"
#include "common/participant/participant.hpp"
#include "common/solver/body_state.hpp"

namespace ricochet::solver {

/// What a participant knows of the mean axial stress in the layers of its bodies, for output.axial_stress_every of the
/// scene: <output directory>/<participant>.axial_stress, which the coupler adds up to axial_stress.csv.
///
/// The first line names the columns: time_s, then BODY/LOW/HIGH/SHARE for each layer in which the participant has
/// elements: borders of the layer on the axis [m], and its share of the layer's volume. Values: its share of the
/// layer's mean axial stress [Pa], tension positive. One line each so many windows, the start included.
class AxialStressFile {
 public:
  /// Most layers of one body.
  static constexpr int most_layers = 100;

  AxialStressFile() = default;  ///< writes nothing
  /// `states`: as they will be given to `add`. Throws ConfigError if the file cannot be written.
  AxialStressFile(const scene::Problem& problem, const std::string& participant, const participant::Setup& setup,
                  const std::vector<BodyState>& states);

  /// The state at the end of a window, if the scene asks for that window.
  void add(std::int64_t window, const std::vector<BodyState>& states);

 private:
  struct Body {
    fem::SparseMatrix shares;  ///< layers with own elements x dofs
    Eigen::VectorXd stress;
  };
  [[nodiscard]] std::string add_body(const scene::Problem& problem, const BodyState& state);

  std::int64_t every_ = 0;  ///< windows; 0: never
  double window_size_s_ = 0.0;
  std::string path_, line_;
  std::vector<Body> bodies_;
  std::ofstream file_;
};

}  // namespace ricochet::solver
