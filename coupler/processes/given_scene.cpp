#include "coupler/processes/given_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <iterator>
#include <regex>

#include "common/base/error.hpp"
#include "coupler/processes/machine_check.hpp"

namespace ricochet::coupler {
namespace {

/// An empty file that goes with it.
class TemporaryScene {
 public:
  TemporaryScene() : path_((std::filesystem::temp_directory_path() / "ricochet_XXXXXX.toml").string()) {
    const int file = mkstemps(path_.data(), 5);
    if (file < 0) throw_errno(errno, "cannot create a file in " + std::filesystem::temp_directory_path().string());
    close(file);
  }
  TemporaryScene(const TemporaryScene&) = delete;
  TemporaryScene& operator=(const TemporaryScene&) = delete;
  ~TemporaryScene() { unlink(path_.c_str()); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace

std::vector<scene::Override> GivenScene::changes() const {
  std::vector<scene::Override> result;
  std::transform(set.begin(), set.end(), std::back_inserter(result), scene::parse_override);
  return result;
}

void GivenScene::add(const std::vector<scene::Override>& changes) {
  std::transform(changes.begin(), changes.end(), std::back_inserter(set), scene::to_argument);
}

scene::Problem GivenScene::load() const {
  if (set.empty()) return load_problem(path);
  const TemporaryScene changed;
  scene::write_variant(path, changes(), changed.path());
  // The changed file has its keys in another order: its lines say nothing.
  try {
    auto problem = load_problem(changed.path());
    problem.scene.path = path;
    for (auto& [key, line] : problem.scene.lines) line = 0;
    return problem;
  } catch (const ConfigError& error) {
    const std::string text = error.what(), title = text.substr(0, text.find('\n'));
    const std::regex place("^\\S*/ricochet_\\w{6}\\.toml(:\\d+)?: ");
    throw ConfigError(
        fmt::format("{} with --set {}: {}", path, fmt::join(set, " --set "), std::regex_replace(title, place, "")));
  }
}

std::string changed_scene_name(const std::string& scene_path) {
  return "scene/" + std::filesystem::path(scene_path).stem().string() + ".toml";
}

std::string write_changed_scene(const std::string& scene_path, const std::vector<scene::Override>& changes,
                                const std::string& results) {
  std::string path = results + "/" + changed_scene_name(scene_path);
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), error);
  if (error) throw_errno(error.value(), "cannot create the folder of " + path);
  scene::write_variant(scene_path, changes, path);
  return path;
}

}  // namespace ricochet::coupler
