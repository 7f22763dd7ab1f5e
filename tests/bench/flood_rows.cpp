#include "tests/bench/flood_rows.hpp"

#include <algorithm>

#include "common/scene/variant.hpp"
#include "tests/bench/flooder.hpp"
#include "tests/bench/reference_scene.hpp"

namespace ricochet::bench {
namespace {

constexpr int refinement = 2;
/// Runs of each kind in a repeat, of which the fastest counts: four busy processes and a flood share few cores, and a
/// run that others disturb takes several times as long.
constexpr int pairs = 3;

}  // namespace

SceneRun Floods::run_at(std::uint16_t port, std::uint16_t flooded_port) const {
  SceneChoice choice;
  choice.refinement = refinement;
  choice.steps = refinement * steps_;
  choice.transport = "tcp";
  const std::string scene = write_reference_scene(choice, folder_ + "/flood.toml");
  scene::write_variant(scene, {{"coupling.port", static_cast<double>(port)}}, scene);
  const Flooder flooder(flooded_port);
  return run_scene(scene, choice.substeps, folder_ + "/run");
}

void Floods::repeat() {
  const OtherPort other;
  for (int pair = 0; pair < pairs; ++pair) {
    const auto port = free_port();
    flooded_.push_back(run_at(port, port));
    elsewhere_.push_back(run_at(port, other.number()));
  }
}

std::vector<Row> Floods::rows() const {
  std::vector<Row> rows;
  const auto compare = [&](const char* what, auto time_s) {
    const auto least = [time_s](const std::vector<SceneRun>& runs) {
      std::vector<double> values;
      for (std::size_t i = 0; i < runs.size(); ++i) {
        const double value = time_s(runs[i]);
        if (i % pairs == 0) values.push_back(value);
        values.back() = std::min(values.back(), value);
      }
      return values;
    };
    rows.push_back({std::string("hughes_liu over tcp: its port flooded / another port flooded, ") + what,
                    mesh_name(refinement), quotients(least(flooded_), least(elsewhere_)), Level{true, 1.10}});
  };
  compare("stepping", [](const SceneRun& run) { return run.stepping_s; });
  compare("whole run", [](const SceneRun& run) { return run.wall_s; });
  compare("processor time of the whole command", [](const SceneRun& run) { return run.usage.cpu_s; });
  return rows;
}

}  // namespace ricochet::bench
