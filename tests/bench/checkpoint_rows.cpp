#include "tests/bench/checkpoint_rows.hpp"

#include <algorithm>

#include "common/scene/variant.hpp"
#include "tests/bench/reference_scene.hpp"

namespace ricochet::bench {

/// The least of three: of runs that others disturb nothing can be said.
double CheckpointCosts::wall_s(int refinement, bool checkpoints) const {
  SceneChoice choice;
  choice.refinement = refinement;
  choice.steps = refinement * steps_;
  const std::string scene = write_reference_scene(choice, folder_ + "/checkpoint.toml");
  if (checkpoints)
    scene::write_variant(scene, {{"checkpoint.every_windows", static_cast<double>(choice.steps / cuts)}}, scene);
  double least = run_scene(scene, choice.substeps, folder_ + "/run").wall_s;
  for (int again = 0; again < 2; ++again)
    least = std::min(least, run_scene(scene, choice.substeps, folder_ + "/run").wall_s);
  return least;
}

void CheckpointCosts::repeat() {
  for (const int refinement : refinements_) {
    with_[refinement].push_back(wall_s(refinement, true));
    without_[refinement].push_back(wall_s(refinement, false));
  }
}

std::vector<Row> CheckpointCosts::rows() const {
  std::vector<Row> rows;
  for (const int refinement : refinements_) {
    Row whole{"hughes_liu, whole run: with 5 checkpoints / without",
              mesh_name(refinement),
              quotients(with_.at(refinement), without_.at(refinement)),
              {}};
    Row interval{
        "hughes_liu: time with a checkpoint every 300 s / without", mesh_name(refinement), {}, Level{true, 1.01}};
    for (std::size_t i = 0; i < whole.ratios.size(); ++i) {
      const double one_s = (with_.at(refinement)[i] - without_.at(refinement)[i]) / (cuts + 1);  // one at the end
      interval.ratios.push_back(1.0 + one_s / default_interval_s);
    }
    rows.push_back(std::move(whole));
    rows.push_back(std::move(interval));
  }
  return rows;
}

}  // namespace ricochet::bench
