#include "coupler/processes/executable.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

bool executable(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && access(path.c_str(), X_OK) == 0;
}

std::string in_search_path(const scene::ParticipantSpec& participant) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (executable(fs::path(folder) / participant.executable)) return fs::path(folder) / participant.executable;
  }
  throw ParticipantError(
      fmt::format("participant '{}': the program {} is in no folder of PATH; correct `executable` in the "
                  "scene (a path with '/' counts from the folder of the scene file)",
                  participant.name, participant.executable));
}

fs::path shipped_path(scene::Role role) {
  std::error_code error;
  const auto self = fs::read_symlink("/proc/self/exe", error);
  if (error)
    throw MachineError(
        fmt::format("cannot read /proc/self/exe: {} (errno {}); ricochet needs /proc", error.message(), error.value()));
  return self.parent_path() / shipped_program(role);
}

}  // namespace

std::string shipped_program(scene::Role role) {
  return role == scene::Role::explicit_solver ? "explicit_solver" : "implicit_solver";
}

std::string find_executable(const scene::Scene& scene, const scene::ParticipantSpec& participant) {
  const bool own = participant.executable.empty();
  const bool bare_name = !own && participant.executable.find('/') == std::string::npos;
  if (bare_name) return in_search_path(participant);
  fs::path path = own ? shipped_path(participant.role) : fs::path(scene.path).parent_path() / participant.executable;
  path = fs::absolute(path).lexically_normal();
  if (executable(path)) return path.string();
  const std::string advice = own ? "build it (cmake --build), or name another program with `executable` in the scene"
                                 : "correct `executable` in the scene, paths count from the folder of the scene file";
  throw ParticipantError(fmt::format("participant '{}': the program {} {}; {}", participant.name, path.string(),
                                     fs::exists(path) ? "may not be executed (chmod +x?)" : "does not exist", advice));
}

}  // namespace ricochet::coupler
