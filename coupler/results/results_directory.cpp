#include "coupler/results/results_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <map>
#include <system_error>

#include "common/base/error.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/results/history_file.hpp"

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

ResultsDirectory::ResultsDirectory(const std::string& path, const std::vector<std::string>& names,
                                   const std::vector<std::string>& inputs, Former former)
    : path_(fs::absolute(path).lexically_normal().string()) {
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  make_folder("");
  descriptor_ = open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor_ < 0) throw_errno(errno, "cannot open the results folder " + path_);
  try {
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      throw ConfigError(
          fmt::format("another run is writing to {}; give this one its own folder with --out DIR", path_));
    }
    own_ = std::make_unique<OwnFiles>(path_);
    own_->keep(inputs);
    own_->claim(names, former == Former::kept ? OwnFiles::Changed::accepted : OwnFiles::Changed::refused);
    if (former == Former::removed) {
      own_->remove_all();
      remove_charts();
    } else {
      own_->remove_halves();
    }
    for (const auto* folder : {"logs", "fields"}) make_folder(folder);
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

ResultsDirectory::~ResultsDirectory() {
  own_.reset();
  std::error_code ignored;
  for (const auto& folder : made_) fs::remove(folder, ignored);  // only if it is empty
  close(descriptor_);
}

/// Pictures of former results, which `ricochet report` keeps a list of its own of.
void ResultsDirectory::remove_charts() const {
  std::error_code ignored;
  if (!fs::is_directory(fs::symlink_status(file("charts"), ignored))) return;
  OwnFiles(file("charts")).remove_all();
  fs::remove(file("charts"), ignored);  // only if it is empty
}

void ResultsDirectory::go_on_from(std::int64_t window, const std::vector<std::string>& participants) const {
  CheckpointFolder(file("checkpoint")).forget_after(window);
  std::vector<fs::path> later;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(file("fields"), ignored)) {
    const auto name = entry.path().filename().string();
    for (const auto& participant : participants) {
      if (window_of(name, participant) > window) later.push_back(entry.path());
    }
  }
  for (const auto& path : later) fs::remove(path, ignored);
}

void ResultsDirectory::make_folder(const std::string& name) {
  std::error_code error;
  const auto folder = name.empty() ? path_ : file(name);
  const bool made = fs::create_directories(folder, error);
  if (error) throw_errno(error.value(), "cannot create the results folder " + folder);
  if (made && !name.empty()) made_.push_back(folder);
}

bool is_being_written(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  close(descriptor);
  return locked;
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
