#include "tests/bench/set_up_rows.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "tests/bench/reference_scene.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {
namespace {

constexpr int fine = 8, finer = 16;  // refinements of 1600 quadrilaterals a body: 102 400 and 409 600
constexpr long steps = 4;

std::string name_of(int refinement) { return fmt::format("2 x {} quadrilaterals", 1600 * refinement * refinement); }

}  // namespace

void SetUps::repeat() {
  const std::string folder = folder_ + "/set_up";
  std::filesystem::create_directories(folder);
  for (const std::string protocol : {"hughes_liu", "all_explicit"}) {
    for (const int refinement : {fine, finer}) {
      SceneChoice choice;
      choice.refinement = refinement;
      choice.protocol = protocol;
      choice.steps = steps;
      const auto scene = write_reference_scene(choice, folder + "/scene.toml");
      Times& times = times_[{protocol, refinement}];
      times.check_s.push_back(
          run_command({test::build_folder() + "/ricochet", "check", scene}, folder + "/check.log").wall_s);
      times.begin_s.push_back(run_scene(scene, 1, folder + "/run").setup_s);
    }
  }
}

std::vector<Row> SetUps::rows() const {
  constexpr double wanted_check_s = 1.0, wanted_begin_s = 2.0, wanted_power = 1.1;
  const auto over = [](std::vector<double> values, double by) {
    for (double& value : values) value /= by;
    return values;
  };
  const auto power = [](const std::vector<double>& large, const std::vector<double>& small) {
    std::vector<double> powers;
    for (const double ratio : quotients(large, small)) powers.push_back(std::log(ratio) / std::log(4.0));
    return powers;
  };
  std::vector<Row> rows;
  for (const std::string protocol : {"hughes_liu", "all_explicit"}) {
    const Times &small = times_.at({protocol, fine}), &large = times_.at({protocol, finer});
    // The factor of the implicit part, a share of each body, grows faster than that.
    const auto growth = protocol == "all_explicit" ? std::optional<Level>({true, wanted_power}) : std::nullopt;
    rows.push_back({protocol + ": check / 1 s", name_of(fine), over(small.check_s, wanted_check_s), Level{true, 1.0}});
    rows.push_back(
        {protocol + ": start and set-up / 2 s", name_of(fine), over(small.begin_s, wanted_begin_s), Level{true, 1.0}});
    rows.push_back({protocol + ": check, power of the elements", name_of(finer), power(large.check_s, small.check_s),
                    Level{true, wanted_power}});
    rows.push_back({protocol + ": start and set-up, power of the elements", name_of(finer),
                    power(large.begin_s, small.begin_s), growth});
  }
  return rows;
}

}  // namespace ricochet::bench
