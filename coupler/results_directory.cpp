#include "coupler/results_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>

#include "common/base/error.hpp"
#include "coupler/history_file.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

/// Window of "<participant>_<window>.vtu"; -1 if the name is not of that form.
long long window_of(const std::string& file, const std::string& participant) {
  const std::string head = participant + "_", tail = ".vtu";
  if (file.size() <= head.size() + tail.size() || file.compare(0, head.size(), head) != 0) return -1;
  const std::string digits = file.substr(head.size(), file.size() - head.size() - tail.size());
  const bool number = std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  return number && file.compare(file.size() - tail.size(), tail.size(), tail) == 0 ? std::stoll(digits) : -1;
}

}  // namespace

ResultsDirectory::ResultsDirectory(const std::string& path) : path_(fs::absolute(path).lexically_normal().string()) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  std::error_code error;
  for (const auto* folder : {"logs", "fields"}) {
    fs::create_directories(file(folder), error);
    if (error) throw ConfigError(fmt::format("cannot create the results folder {}: {}", file(folder), error.message()));
  }
  descriptor_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0)
    throw ConfigError(fmt::format("cannot open the results folder {}: {}", path_, std::strerror(errno)));
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
    close(descriptor_);
    throw ConfigError(fmt::format("another run is writing to {}; give this one its own folder with --out DIR", path_));
  }
  remove_former_results();
}

ResultsDirectory::~ResultsDirectory() {
  std::error_code ignored;
  for (const auto* folder : {"fields", "logs", "charts"}) fs::remove(file(folder), ignored);  // only if it is empty
  close(descriptor_);
}

void ResultsDirectory::remove_former_results() const {
  std::error_code ignored;
  for (const auto* name :
       {"history.csv", "axial_stress.csv", "calibration.csv", "scene.toml", "summary.json", "trace.json", "report.html",
        "stability.csv", "stability.html", "results.csv", "histories.csv", "study.json"}) {
    fs::remove(file(name), ignored);
  }
  static const std::map<std::string, std::set<std::string>> ours = {
      {"fields", {".vtu", ".pvd", ".axial_stress"}}, {"logs", {".log"}}, {"variants", {".toml"}}, {"charts", {".svg"}}};
  for (const auto& [folder, extensions] : ours) {
    std::vector<fs::path> old;
    for (const auto& entry : fs::directory_iterator(file(folder), ignored)) {
      if (extensions.count(entry.path().extension().string()) > 0) old.push_back(entry.path());
    }
    for (const auto& path : old) fs::remove(path, ignored);
  }
}

void write_pvd(const ResultsDirectory& results, const std::string& name, const std::vector<std::string>& participants,
               double window_size_s) {
  std::map<std::pair<long long, std::size_t>, std::string> snapshots;
  for (const auto& entry : fs::directory_iterator(results.file("fields"))) {
    const std::string file = entry.path().filename().string();
    for (std::size_t p = 0; p < participants.size(); ++p) {
      const long long window = window_of(file, participants[p]);
      if (window >= 0) snapshots[{window, p}] = file;
    }
  }
  if (snapshots.empty()) return;
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  "
      "<Collection>\n";
  for (const auto& [key, file] : snapshots) {
    text += fmt::format("    <DataSet timestep=\"{:.17g}\" part=\"{}\" file=\"{}\"/>\n",
                        static_cast<double>(key.first) * window_size_s, key.second, file);
  }
  write_atomically(results.file("fields/" + name + ".pvd"), text + "  </Collection>\n</VTKFile>\n");
}

}  // namespace ricochet::coupler
