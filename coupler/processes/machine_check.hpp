#pragma once

#include <string>

#include "common/problem/problem.hpp"
#include "common/scene/scene.hpp"

/// Whether this machine can compute a scene, before it tries.
namespace ricochet::coupler {

/// Main memory that a run of the scene takes, all processes of this machine together [bytes], without the factors of
/// implicit participants; an estimate by the number of nodes, which of a Gmsh mesh that is not read yet follows from
/// the size of its file.
[[nodiscard]] double memory_need_bytes(const scene::Scene& scene);
[[nodiscard]] double memory_need_bytes(const scene::Problem& problem);
/// The memory that there is [bytes]: free or easily freed memory, or the limit of this process if that is less.
[[nodiscard]] double memory_available_bytes();
/// "memory: about 1.2 GB needed, 7.8 GB available".
[[nodiscard]] std::string memory_text(double need_bytes);

/// Loads a scene that this machine can compute. Throws ConfigError for a wrong scene, MachineError if memory or file
/// descriptors do not suffice.
[[nodiscard]] scene::Problem load_problem(const std::string& path);

/// A warning of the address at which the scene's coupler listens; empty: nobody but this machine can reach it.
[[nodiscard]] std::string address_warning(const scene::Scene& scene);

}  // namespace ricochet::coupler
