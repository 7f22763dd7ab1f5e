#include "coupler/results/obstacles_file.hpp"

#include <nlohmann/json.hpp>

#include "common/problem/drawn_obstacles.hpp"

namespace ricochet::coupler {

std::string obstacles_text(const scene::Problem& problem) {
  const auto drawn = scene::drawn_obstacles(problem);
  if (drawn.empty()) return "";
  nlohmann::ordered_json file = {{"format", "ricochet obstacles 1"}, {"obstacles", nlohmann::ordered_json::array()}};
  for (const auto& obstacle : drawn) {
    nlohmann::ordered_json places;
    for (const auto& x : obstacle.place) places.push_back({x[0], x[1], x[2]});
    file["obstacles"].push_back({{"name", obstacle.name},
                                 {"strip_m", obstacle.strip_m},
                                 {"place_m", std::move(places)},
                                 {"cell", obstacle.cells}});
  }
  return file.dump();
}

}  // namespace ricochet::coupler
