#pragma once

#include <map>
#include <optional>
#include <string>

#include "coupler/processes/given_scene.hpp"
#include "coupler/results/results_directory.hpp"

namespace ricochet::coupler {

struct AdviceRequest {
  GivenScene scene;
  std::optional<std::string> quantity;  ///< as `error_bar` names it (values_of); empty: the scene's table [accuracy]
  std::optional<double> error;          ///< asked of it: relative
  std::string out;                      ///< folder of the pilot runs; empty: "out/<name of the scene file>_advice"
};

/// `ricochet advise`: which protocol and step reach an error on the scene's own mesh in the least predicted time, and
/// which is next (choose_method). It prints all that and writes `out`/advice.csv. ConfigError: what cannot be asked,
/// and an error that no candidate reaches.
void advise(const AdviceRequest& request);

struct ChosenByAccuracy {
  std::string scene;                       ///< the file to run: scene/NAME.toml in that folder, with protocol and step
  std::map<std::string, double> expected;  ///< relative error of each quantity
};
/// `ricochet run` of a scene with a table [accuracy]: does the same in the folder of its results, for what the scene
/// leaves open.
[[nodiscard]] ChosenByAccuracy choose_by_accuracy(const scene::Problem& problem, const ResultsDirectory& results);

}  // namespace ricochet::coupler
