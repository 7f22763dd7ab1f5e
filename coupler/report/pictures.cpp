#include "coupler/report/pictures.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/own_files.hpp"
#include "common/base/write_file.hpp"
#include "coupler/report/assets/assets.hpp"

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

/// A folder that nobody else knows, gone with this object.
class ScratchFolder {
 public:
  explicit ScratchFolder(const fs::path& parent) : path_((parent / ".charts-XXXXXX").string()) {
    if (!mkdtemp(path_.data())) throw_errno(errno, "cannot create a folder in " + parent.string());
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Exit code of a program looked up on PATH that reads `input`; what it prints goes where ours goes. -1: there is none
/// of that name.
int run_program(const std::vector<std::string>& words, const std::string& input) {
  std::vector<char*> arguments;
  for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const int file = memory_file(input);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, file, STDIN_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(file);
  if (error == ENOENT) return -1;
  if (error != 0) throw_errno(error, "cannot start " + words[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Puts the pictures in the place of those that were drawn before.
void put_in_place(const fs::path& results, const std::vector<fs::path>& pictures) {
  const auto folder = results / "charts";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw_errno(error.value(), "cannot create the folder " + folder.string());
  OwnFiles own(folder.string());
  std::vector<std::string> names;
  for (const auto& picture : pictures) names.push_back(picture.filename().string());
  own.claim(names);
  own.remove_all();
  for (const auto& picture : pictures) fs::rename(picture, folder / picture.filename());
}

}  // namespace

Pictures draw_pictures(const Page& page) {
  const auto results = fs::absolute(page.path).parent_path();
  Pictures pictures{(results / "charts").string(), 0, ""};
  const ScratchFolder scratch(results);
  const int code = run_program({"node", "-e", std::string(asset("draw_pictures.js")), scratch.path()}, page.text);
  if (code > 0)
    throw ParticipantError(fmt::format("node could not draw the charts of {}: exit code {}", page.path, code));
  if (code < 0) {
    pictures.obstacle = "no picture files: `node` is not on PATH; install the Debian package nodejs (18 or later)";
    return pictures;
  }
  const auto files = svg_files(scratch.path());
  put_in_place(results, files);
  pictures.count = static_cast<int>(files.size());
  return pictures;
}

}  // namespace ricochet::report
