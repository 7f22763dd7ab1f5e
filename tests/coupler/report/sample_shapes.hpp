#pragma once

#include <string>
#include <tuple>
#include <vector>

#include "common/base/base64.hpp"
#include "coupler/report/parts/chart.hpp"

namespace ricochet::report {

template <class Number>
Json packed_numbers(const std::vector<Number>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)});
}
inline Json packed_floats(const std::vector<float>& values) { return packed_numbers(values); }
inline Json packed_ints(const std::vector<int>& values) { return packed_numbers(values); }

/// A square of 1 m: the body's name, x of its lower left corner, numbers of its nodes in the body.
using Square = std::tuple<std::string, double, std::vector<int>>;

/// The file of a participant in plane strain with one square element for each body; windows of 0.5 s, in which each
/// node is displaced by a tenth of the window's number [m] along x, and the stress is that number [Pa].
inline Json square_file(const std::vector<int>& windows, const std::vector<Square>& squares) {
  std::vector<double> times;
  for (const int window : windows) times.push_back(0.5 * window);
  Json file = {{"format", "ricochet shapes 2"},
               {"model", "plane_strain"},
               {"largest_window_s", 0.5},
               {"nose", false},
               {"uneven", false},
               {"windows", windows},
               {"times_s", times},
               {"too_many_cells", 0},
               {"bodies", Json::array()}};
  for (const auto& [name, x, nodes] : squares) {
    const auto left = static_cast<float>(x), right = left + 1;
    Json displacements = Json::array(), stresses = Json::array();
    for (const int window : windows) {
      const float u = 0.1F * static_cast<float>(window);
      displacements.push_back(packed_floats({u, 0, u, 0, u, 0, u, 0}));
      stresses.push_back(packed_floats({static_cast<float>(window)}));
    }
    file["bodies"].push_back({{"name", name},
                              {"strip_m", 0},
                              {"initial_velocity_m_s", {0, 0, 0}},
                              {"node", packed_ints(nodes)},
                              {"position_m", packed_floats({left, 0, right, 0, right, 1, left, 1})},
                              {"cell", packed_ints({0, 1, 2, 3})},
                              {"displacement_m", displacements},
                              {"stress_pa", stresses}});
  }
  return file;
}

}  // namespace ricochet::report
