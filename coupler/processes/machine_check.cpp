#include "coupler/processes/machine_check.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <variant>

#include "common/base/error.hpp"
#include "common/base/process.hpp"

namespace ricochet::coupler {
namespace {

/// Bytes of a process without a scene, and per node, from the peak resident memory of runs with 2e5 nodes in two
/// dimensions, 1e6 in one and 1.3e5 in three, where the assembled stiffness takes most. The factor of many implicit
/// unknowns comes on top.
constexpr double coupler_bytes = 25e6, participant_bytes = 12e6;
struct PerNode {
  double everywhere;    ///< in every process, the coupler among them
  double coupler;       ///< there besides, before participants are started
  double participants;  ///< in all of them together besides
};
constexpr PerNode in_one_dimension{135, 155, 325}, in_two_dimensions{335, 465, 610},
    in_three_dimensions{650, 2600, 2750};
constexpr double bytes_per_node_of_gmsh_file = 40;  // of the file, which is text or binary

double nodes_of(const scene::Body& body) {
  double nodes = 0.0;
  for (const auto& piece : body.pieces) {
    std::error_code ignored;
    if (const auto* mesh = std::get_if<scene::StructuredMesh>(&piece.elements))
      nodes += mesh->nodes_in_layer() * (mesh->elements_along + 1.0);
    else
      nodes +=
          static_cast<double>(std::filesystem::file_size(std::get<scene::GmshMesh>(piece.elements).path, ignored)) /
          bytes_per_node_of_gmsh_file;
  }
  return nodes;
}

std::string size_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", std::ceil(1e-6 * bytes)) : fmt::format("{:.1f} GB", 1e-9 * bytes);
}

double need_bytes(const scene::Scene& scene, double nodes) {
  const bool here = scene.coupling.launcher == scene::LaunchedBy::coupler;
  const auto launched =
      static_cast<double>(std::count_if(scene.participants.begin(), scene.participants.end(),
                                        [here](const auto& p) { return here && p.start == scene::Start::launch; }));
  const PerNode& per_node = scene.components() == 1   ? in_one_dimension
                            : scene.components() == 2 ? in_two_dimensions
                                                      : in_three_dimensions;
  return coupler_bytes + launched * participant_bytes +
         nodes * (per_node.everywhere * (launched + 1.0) + per_node.coupler +
                  (launched > 0.0 ? per_node.participants : 0.0));
}

}  // namespace

double memory_need_bytes(const scene::Scene& scene) {
  double nodes = 0.0;
  for (const auto& body : scene.bodies) nodes += nodes_of(body);
  return need_bytes(scene, nodes);
}

double memory_need_bytes(const scene::Problem& problem) {
  double nodes = 0.0;
  for (const auto& body : problem.bodies) nodes += static_cast<double>(body.mesh.position.size());
  return need_bytes(problem.scene, nodes);
}

double memory_available_bytes() {
  double available = std::numeric_limits<double>::infinity();
  std::ifstream file("/proc/meminfo");
  for (std::string word, value; file >> word >> value;) {
    if (word == "MemAvailable:") available = 1024.0 * std::stod(value);
    file.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    available = std::min(available, static_cast<double>(limit.rlim_cur));
  }
  return available;
}

std::string memory_text(double need_bytes) {
  return fmt::format("memory: about {} needed, {} available", size_text(need_bytes),
                     size_text(memory_available_bytes()));
}

scene::Problem load_problem(const std::string& path) {
  const auto scene = scene::load_scene(path);
  require_proc();
  constexpr unsigned long own_descriptors = 256, per_participant = 8;  // 128 of them for connections of strangers
  require_descriptors(own_descriptors + per_participant * scene.participants.size());
  if (const double need = memory_need_bytes(scene); need > memory_available_bytes()) {
    throw MachineError(fmt::format("{}: {}; fewer elements need less", scene.path, memory_text(need)));
  }
  return scene::build_problem(scene);
}

std::string address_warning(const scene::Scene& scene) {
  const auto& address = scene.coupling.address;
  const bool asked =
      scene.coupling.transport == Transport::tcp && scene.coupling.launcher == scene::LaunchedBy::coupler;
  if (!asked || address == "127.0.0.1" || address == "localhost" || address == "::1" || address == "[::1]") return "";
  return fmt::format(
      "coupling.address: found \"{}\", which other machines can reach; only who has a key of the run gets through, and "
      "what is sent is encrypted (docs/security.md); \"127.0.0.1\" stays on this machine",
      address);
}

}  // namespace ricochet::coupler
