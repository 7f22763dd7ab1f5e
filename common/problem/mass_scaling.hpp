#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"

/// Mass scaling, the usual way to a longer step of `all_explicit`: an element e whose own critical step dt_e (element
/// bound) is too short for a step dt gets (dt / (s dt_e))^2 times its density, s the safety factor, which makes its
/// critical step dt / s. Stiffness stays, so that waves in it are slower and what it pushes against is heavier.
namespace ricochet::scene {

/// density_factor of a body, if the scene has mass scaling.
void scale_mass(const Scene& scene, BodyProblem& body);

/// Elements of a body as fem::extract_part makes them, with the masses that scaling gives them.
[[nodiscard]] fem::Part body_part(const BodyProblem& body, const std::vector<int>& elements,
                                  const std::vector<int>& extra_nodes = {});
/// Adds to the mass per node of the whole body what scaling adds, in the order of body_part [kg].
void add_scaled_mass(const BodyProblem& body, Eigen::VectorXd& mass);

/// The change that scaling makes to a body.
struct AddedMass {
  struct AtContact {
    std::string name;  ///< of one of several contacts
    int elements = 0;  ///< scaled ones with a node of it
  };
  int elements = 0;             ///< scaled ones
  double kg = 0.0;              ///< more than they have by their density
  double share = 0.0;           ///< kg over what the whole body has by its density
  double largest_factor = 1.0;  ///< of a density
  std::vector<AtContact> contacts;
};
[[nodiscard]] AddedMass added_mass(const Problem& problem, int body);

}  // namespace ricochet::scene
