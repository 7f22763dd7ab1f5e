#include "tests/bench/rank_rows.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "tests/bench/rank_scene.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {
namespace {

constexpr int plane_elements = 640, solid_elements = 28, solid_deep = 8;

/// Twice as large is two of these side by side in the plane, and about as much in solids: 40^2 = 2.04 * 28^2.
RankScene scene_of(bool solid, bool twice_as_large) {
  RankScene scene;
  scene.solid = solid;
  if (solid) {
    scene.elements = twice_as_large ? 40 : solid_elements;
    scene.deep = solid_deep;
  } else {
    scene.elements = plane_elements * (twice_as_large ? 2 : 1);
  }
  return scene;
}

std::string name_of(bool solid) {
  const RankScene scene = scene_of(solid, false);
  return solid ? fmt::format("{} hexahedra", 2 * scene.elements * scene.elements * scene.deep)
               : fmt::format("{} quadrilaterals", 2 * scene.elements * scene.deep);
}

}  // namespace

void RankRuns::repeat() {
  if (!std::filesystem::exists(test::build_folder() + "/explicit_solver_mpi")) return;
  const std::string folder = folder_ + "/ranks";
  std::filesystem::create_directories(folder);
  for (const bool solid : {false, true}) {
    for (const auto& [large, ranks] : {std::pair(false, 1), std::pair(false, 2), std::pair(true, 2)}) {
      RankScene scene = scene_of(solid, large);
      scene.steps = steps_;
      scene.ranks = ranks;
      const auto path = write_rank_scene(scene, folder + "/scene.toml");
      window_s_[{solid, large, ranks}].push_back(run_scene(path, 1, folder + "/run").window_s);
    }
  }
}

std::vector<Row> RankRuns::rows() const {
  std::vector<Row> rows;
  for (const bool solid : {false, true}) {
    if (window_s_.empty()) {
      rows.push_back(
          {"all_explicit, stepping: no MPI / two ranks", name_of(solid), {}, {}, "built without OpenMPI or METIS"});
      continue;
    }
    const auto& alone = window_s_.at({solid, false, 1});
    rows.push_back({"all_explicit, stepping: no MPI / two ranks",
                    name_of(solid),
                    quotients(alone, window_s_.at({solid, false, 2})),
                    {}});
    rows.push_back({"the same, two ranks with bodies twice as large (weak scaling)",
                    name_of(solid),
                    quotients(alone, window_s_.at({solid, true, 2})),
                    {}});
  }
  return rows;
}

}  // namespace ricochet::bench
