#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/problem/problem.hpp"

namespace ricochet::solver {

/// Mean over the surface of the (first) contact of the most compressive principal stress, positive in compression [Pa]:
///   sigma_mean = - sum_e A_e sigma_III(middle of the face of e) / sum_e A_e
/// over the faces of the contact surface that have a contact node, of the first body that has any here (the scene's
/// first surface first). Faces beyond those nodes are nowhere near the contact, and may be with another participant
/// or rank. This is the "mean value of principal stress on the contact surface" of the paper's Fig. 3-5.
class SurfaceStress {
 public:
  SurfaceStress() = default;
  SurfaceStress(const scene::Problem& problem, const std::vector<BodyState>& states);

  /// `displacement_of_part`: what strains it (BodyState::straining). 0 if no element of the surface is here.
  template <class DisplacementOfPart>
  [[nodiscard]] double mean(const DisplacementOfPart& displacement_of_part) const {
    if (elements_.empty()) return 0.0;
    double sum = 0.0;
    const auto& u = displacement_of_part(part_);
    for (const auto& own : elements_) sum += own.area_m2 * -smallest_principal(own, u);
    return sum / area_m2_;
  }

 private:
  struct Element {
    std::vector<int> dofs;
    Eigen::MatrixXd stress_of_displacement;  ///< stress in the middle of the face per unit nodal displacement [Pa/m]
    double area_m2 = 0.0;
    int element = 0;  ///< of the part
  };
  [[nodiscard]] double smallest_principal(const Element& own, const Eigen::Ref<const Eigen::VectorXd>& u) const;
  bool collect(const scene::Problem& problem, const std::vector<BodyState>& states, int body, bool first);

  fem::Model model_ = fem::Model::bar;
  int part_ = -1;
  std::shared_ptr<const PlasticState> plastic_;  ///< of the part, if that yields
  double area_m2_ = 0.0;
  std::vector<Element> elements_;
};

}  // namespace ricochet::solver
