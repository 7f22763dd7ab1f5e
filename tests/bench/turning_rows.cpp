#include "tests/bench/turning_rows.hpp"

#include <fmt/format.h>

#include "common/base/write_file.hpp"
#include "tests/support/plane_grid.hpp"

namespace ricochet::bench {
namespace {

constexpr double radius_m = 0.01, apart_m = 1e-6;
constexpr int lower_cells = 48, upper_cells = 52;

struct Method {
  const char *protocol, *step, *partition;
};
constexpr Method methods[] = {{"all_explicit", "safety_factor = 0.6", ""},
                              {"hughes_liu", "step_s = 4e-8", "[partition]\nrule = \"auto\"\n"},
                              {"all_implicit", "step_s = 4e-8", ""}};

struct Kind {
  const char *name, *keys;
};
constexpr Kind without = {"without", ""};
constexpr Kind kinds[] = {{"no spin", "large_rotation = true\n"},
                          {"1000 rad/s", "large_rotation = true\ninitial_angular_velocity_rad_s = 1000.0\n"}};

std::string discs(const Method& method, const char* keys) {
  const auto body = [&](const char* name, double velocity_m_s) {
    return fmt::format(
        "[[body]]\nname = \"{0}\"\nmaterial = {{ youngs_modulus_pa = 210e9, poisson_ratio = 0.3, density_kg_m3 = "
        "7850.0 }}\nmesh = {{ gmsh = \"{0}.msh\" }}\ninitial_velocity_m_s = [0.0, {1}]\n{2}",
        name, velocity_m_s, keys);
  };
  return fmt::format(
      "model = \"plane_strain\"\n{}{}{}[contact]\nsurfaces = [\"steel.rim\", \"other.rim\"]\nnormal = [0.0, 1.0]\n"
      "[time]\n{}\nend_s = 3e-5\n[coupling]\nprotocol = \"{}\"\n",
      body("steel", 5.0), body("other", -5.0), method.partition, method.step, method.protocol);
}

}  // namespace

TurningDiscs::TurningDiscs(std::string folder) : folder_(std::move(folder)) {
  write_atomically(folder_ + "/steel.msh", test::whole_disc_msh("steel", 0.0, -radius_m, radius_m, lower_cells));
  write_atomically(folder_ + "/other.msh",
                   test::whole_disc_msh("other", 0.0, radius_m + apart_m, radius_m, upper_cells));
}

void TurningDiscs::repeat() {
  const std::string scene = folder_ + "/discs.toml";
  for (const Method& method : methods) {
    const auto measure = [&](const Kind& kind) {
      write_atomically(scene, discs(method, kind.keys));
      stepping_s_[{method.protocol, kind.name}].push_back(run_scene(scene, 1, folder_ + "/run").stepping_s);
    };
    measure(without);
    for (const Kind& kind : kinds) measure(kind);
  }
}

std::vector<Row> TurningDiscs::rows() const {
  std::vector<Row> rows;
  for (const Method& method : methods)
    for (const Kind& kind : kinds)
      rows.push_back(
          {fmt::format("discs, {}: large_rotation / without, stepping", method.protocol),
           kind.name,
           quotients(stepping_s_.at({method.protocol, kind.name}), stepping_s_.at({method.protocol, without.name})),
           {}});
  return rows;
}

}  // namespace ricochet::bench
