#include "coupler/report/pictures.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "common/base/error.hpp"
#include "coupler/report/assets.hpp"

namespace ricochet::report {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> svg_files(const std::string& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".svg") files.push_back(entry.path());
  }
  return files;
}

void make_empty(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw ConfigError(fmt::format("cannot create the folder {}: {}", folder, error.message()));
  for (const auto& file : svg_files(folder)) fs::remove(file, error);
  if (error) throw ConfigError(fmt::format("cannot remove an old picture in {}: {}", folder, error.message()));
}

/// Exit code of a program looked up on PATH; what it prints goes where ours goes. -1: there is none of that name.
int run_program(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ);
  if (error == ENOENT) return -1;
  if (error != 0) throw ParticipantError(fmt::format("cannot start {}: {}", words[0], std::strerror(error)));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Pictures draw_pictures(const std::string& page) {
  Pictures pictures{(fs::path(page).parent_path() / "charts").string(), 0, ""};
  make_empty(pictures.folder);
  const int code = run_program({"node", "-e", std::string(asset("draw_pictures.js")), page, pictures.folder});
  if (code > 0) throw ParticipantError(fmt::format("node could not draw the charts of {}: exit code {}", page, code));
  pictures.count = static_cast<int>(svg_files(pictures.folder).size());
  if (code < 0) {
    fs::remove(pictures.folder);
    pictures.obstacle = "no picture files: `node` is not on PATH; install the Debian package nodejs (18 or later)";
  }
  return pictures;
}

}  // namespace ricochet::report
