#include "tests/bench/reference_scene.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <string_view>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "common/scene/variant.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {
namespace {

constexpr int across = 10, along = 160;  // of the 0.5 mm mesh
constexpr double step_s = 5.4e-8, edge_mm = 0.5, length_m = 0.08;

std::string replaced_everywhere(std::string text, std::string_view from, std::string_view to) {
  std::size_t at = text.find(from);
  if (at == std::string::npos) throw ConfigError(fmt::format("configs/kim_impact.toml no longer holds \"{}\"", from));
  for (; at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

std::string config_text() {
  std::ifstream file(test::source_folder() + "/configs/kim_impact.toml");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string two_explicit_participants() {
  return "[[participant]]\nname = \"explicit_steel\"\nrole = \"explicit\"\nbodies = [\"steel\"]\n"
         "[[participant]]\nname = \"explicit_carbide\"\nrole = \"explicit\"\nbodies = [\"carbide\"]\n"
         "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
}

std::string write_reference_scene(const SceneChoice& choice, const std::string& path) {
  const int n = choice.refinement;
  write_atomically(path, replaced_everywhere(config_text(), fmt::format("elements = [{}, {}]", across, along),
                                             fmt::format("elements = [{}, {}]", n * across, n * along)) +
                             choice.participants);
  const double window_s = choice.substeps * step_s / n;
  const auto windows = static_cast<double>(choice.steps / choice.substeps);
  std::vector<scene::Override> overrides = {{"time.step_s", window_s},
                                            {"time.end_s", windows * window_s},
                                            {"time.until_separated_plus_s", 1.0},
                                            {"coupling.protocol", choice.protocol},
                                            {"coupling.transport", choice.transport},
                                            {"coupling.after_separation", "implicit"},
                                            {"output.history_every", choice.every_step ? 1.0 : windows},
                                            {"output.fields_every", 0.0},
                                            {"output.axial_stress_every", 0.0}};
  if (choice.substeps > 1) overrides.push_back({"coupling.substeps", static_cast<double>(choice.substeps)});
  if (choice.carbide_lengths > 1) {
    const double lengths = choice.carbide_lengths;
    overrides.push_back({"body.carbide.mesh.length_m", lengths * length_m});
    overrides.push_back({"body.carbide.mesh.elements", std::vector<double>{1.0 * n * across, lengths * n * along}});
  }
  scene::write_variant(path, overrides, path);
  return path;
}

std::string mesh_name(int refinement) { return fmt::format("{:g} mm", edge_mm / refinement); }

}  // namespace ricochet::bench
