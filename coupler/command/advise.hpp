#pragma once

#include <string>

#include "coupler/processes/given_scene.hpp"

namespace ricochet::coupler {

struct AdviceRequest {
  GivenScene scene;
  std::string quantity;  ///< as `error_bar` names it (values_of)
  double error = 0.0;    ///< asked: relative to the quantity
  std::string out;       ///< folder of the pilot runs; empty: "out/<name of the scene file>_advice"
};

/// `ricochet advise`: which protocol and step reach the error on the scene's own mesh in the least predicted time, and
/// which is next. Candidates are the scene's protocol and the baselines in steps of 1/2 to 16 times its own; in the
/// order of their predicted time each is computed with elements and step of two, four and eight times the length. The
/// bar of the first of these pilots (error_bar), halved at an observed order of one, is what the candidate is expected
/// to have on the scene's mesh. It prints all that and writes `out`/advice.csv. ConfigError: a quantity that the scene
/// has not, an error that is no share, a scene without coarser meshes, and an error that no candidate reaches; that
/// message says the least bar, and how much finer the elements are to be.
void advise(const AdviceRequest& request);

}  // namespace ricochet::coupler
