#include "tests/bench/tied_rows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "common/base/write_file.hpp"

namespace ricochet::bench {
namespace {

constexpr double length_m = 1.0, fine_m = 0.002, edge_m = 2e-5, wave_m_s = 5172.0, courant = 0.9;
constexpr int ratio = 4;
constexpr const char* one_mesh = "all_explicit";

int elements(double of_m, double edge) { return static_cast<int>(std::lround(of_m / edge)); }

std::string bar(const std::string& protocol) {
  const bool tied = protocol != one_mesh;
  const std::string mesh =
      tied ? fmt::format(
                 "[[body.mesh.piece]]\nname = \"fine\"\nlength_m = {0}\nelements = {1}\n[[body.mesh.piece]]\nname = "
                 "\"coarse\"\nstart_m = {0}\nlength_m = {2}\nelements = {3}\n[[body.mesh.tie]]\nsurfaces = "
                 "[\"fine.end\", \"coarse.start\"]\n",
                 fine_m, elements(fine_m, edge_m), length_m - fine_m, elements(length_m - fine_m, ratio * edge_m))
           : fmt::format("mesh = {{ length_m = {}, elements = {} }}\n", length_m, elements(length_m, edge_m));
  return fmt::format(
      "model = \"bar\"\n[[body]]\nname = \"steel\"\nmaterial = {{ youngs_modulus_pa = 210e9, poisson_ratio = 0.3, "
      "density_kg_m3 = 7850.0 }}\narea_m2 = 1e-4\ninitial_velocity_m_s = [-1.0]\n{}[contact]\nsurfaces = "
      "[\"steel.{}start\", \"rigid_plane\"]\n{}[time]\nstep_s = {}\nend_s = 2.2e-4\n[coupling]\nprotocol = \"{}\"\n"
      "[output]\nhistory_every = 100\n",
      mesh, tied ? "fine." : "", protocol == "hughes_liu" ? "[partition]\nrule = \"auto\"\n" : "",
      courant * (tied ? ratio : 1) * edge_m / wave_m_s, protocol);
}

}  // namespace

void TiedBars::repeat() {
  const std::string scene = folder_ + "/bar.toml";
  for (const char* protocol : {one_mesh, "hughes_liu", "local_explicit"}) {
    write_atomically(scene, bar(protocol));
    runs_[protocol].push_back(run_scene(scene, 1, folder_ + "/run"));
  }
}

std::vector<Row> TiedBars::rows() const {
  const auto each = [this](const std::string& protocol, auto value) {
    std::vector<double> values;
    for (const SceneRun& run : runs_.at(protocol)) values.push_back(value(run));
    return values;
  };
  const auto stepping = [](const SceneRun& run) { return run.stepping_s; };
  std::vector<Row> rows;
  for (const char* protocol : {"hughes_liu", "local_explicit"}) {
    rows.push_back({fmt::format("bar, one mesh and step / tied 4:1 by {}, stepping", protocol), "20 um",
                    quotients(each(one_mesh, stepping), each(protocol, stepping)), Level{false, 13.0}});
    const double expected = runs_.at(one_mesh).front().speed_change_m_s;
    rows.push_back(
        {fmt::format("bar, tied 4:1 by {}: error of the impulse against one mesh", protocol), "20 um",
         each(protocol, [&](const SceneRun& run) { return std::abs(run.speed_change_m_s / expected - 1.0); }),
         Level{true, 1e-6}});
  }
  return rows;
}

}  // namespace ricochet::bench
