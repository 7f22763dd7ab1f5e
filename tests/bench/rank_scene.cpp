#include "tests/bench/rank_scene.hpp"

#include <fmt/format.h>

#include "common/base/write_file.hpp"

namespace ricochet::bench {
namespace {

constexpr double edge_m = 1e-3, step_s = 1e-7;  // some 0.4 (solids) and 0.6 of the critical step

std::string body(const RankScene& choice, const char* name, double start_m, double velocity_m_s) {
  const double width_m = edge_m * choice.elements, length_m = edge_m * choice.deep;
  const std::string across =
      choice.solid ? fmt::format("height_m = {0}, width_m = {0}, elements = [{1}, {1}, {2}]", width_m, choice.elements,
                                 choice.deep)
                   : fmt::format("height_m = {}, elements = [{}, {}]", width_m, choice.elements, choice.deep);
  return fmt::format(
      "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 "
      "}}\n"
      "mesh = {{ start_m = {}, length_m = {}, {} }}\ninitial_velocity_m_s = [{}0.0, {:.1f}]\n",
      name, start_m, length_m, across, choice.solid ? "0.0, " : "", velocity_m_s);
}

}  // namespace

std::string write_rank_scene(const RankScene& choice, const std::string& path) {
  const double end_s = static_cast<double>(choice.steps) * step_s;
  write_atomically(
      path,
      fmt::format("model = \"{}\"\n", choice.solid ? "solid" : "plane_strain") +
          body(choice, "steel", -edge_m * choice.deep, 1.0) + body(choice, "carbide", 0.0, -1.0) +
          fmt::format("[contact]\nsurfaces = [\"steel.end\", \"carbide.start\"]\n[time]\nstep_s = {}\nend_s = {}\n"
                      "[coupling]\nprotocol = \"all_explicit\"\n[output]\nhistory_every = {}\nfields_every = 0\n"
                      "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\n"
                      "threads = 1\n",
                      step_s, end_s, choice.steps) +
          (choice.ranks > 1 ? fmt::format("ranks = {}\n", choice.ranks) : ""));
  return path;
}

}  // namespace ricochet::bench
