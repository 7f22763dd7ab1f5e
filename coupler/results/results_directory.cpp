#include "coupler/results/results_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"
#include "coupler/results/checkpoint.hpp"
#include "coupler/results/field_digests.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

/// Reads a line of /proc/locks on a file: "12: FLOCK ADVISORY WRITE 4711 08:01:131 0 EOF", process and inode among
/// it. 0 if no process holds one that can be seen from here.
pid_t holder_of_lock(ino_t inode) {
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, manner, access, file;
    pid_t process = 0;
    if (!(words >> number >> kind >> manner >> access >> process >> file) || kind != "FLOCK") continue;
    if (process > 0 && file.substr(file.rfind(':') + 1) == std::to_string(inode)) return process;
  }
  return 0;
}

std::string user_name(uid_t user) {
  std::array<char, 4096> buffer{};
  passwd entry{}, *found = nullptr;
  const bool known = getpwuid_r(user, &entry, buffer.data(), buffer.size(), &found) == 0 && found;
  return known ? found->pw_name : std::to_string(user);
}

std::string command_of(const std::string& process) {
  std::ifstream file("/proc/" + process + "/comm");
  std::string command;
  std::getline(file, command);
  return command;
}

LockHolder describe_holder(const std::string& path, pid_t process) {
  const auto number = std::to_string(process);
  struct stat status {};
  if (process == 0 || stat(("/proc/" + number).c_str(), &status) != 0) {
    return {true, fmt::format("another run is writing to {}, or a process that cannot be seen from here holds its lock",
                              path)};
  }
  const auto command = command_of(number);
  const bool a_run = command == command_of("self") || command == command_name;
  if (a_run && status.st_uid == geteuid())
    return {true, fmt::format("another run is writing to {} (process {})", path, process)};
  return {a_run, fmt::format("process {} ('{}') of user '{}', which is no run of yours, holds the lock of {}", process,
                             printable(command), user_name(status.st_uid), path)};
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
      const auto holder = lock_holder(path_);
      throw ConfigError(fmt::format("{}; give this one its own folder with --out DIR",
                                    holder ? holder->text : "another run was writing to " + path_ + " a moment ago"));
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
  own_->remove_halves();
  CheckpointFolder(file("checkpoint")).forget_after(window);
  std::vector<fs::path> later;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(file("fields"), ignored)) {
    const auto name = entry.path().filename().string();
    for (const auto& participant : participants) {
      const auto of = field_name(name, participant);
      if (of && of->window > window) later.push_back(entry.path());
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

std::optional<LockHolder> lock_holder(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  const bool locked = flock(descriptor, LOCK_EX | LOCK_NB) != 0;  // a shared one keeps a run away, too
  struct stat status {};
  const bool known = fstat(descriptor, &status) == 0;
  close(descriptor);
  if (!locked) return std::nullopt;
  return describe_holder(path, known ? holder_of_lock(status.st_ino) : 0);
}

namespace {

/// A file of fields in its data set: the bodies in the order of the scene, their participants in that of the set.
using Snapshot = std::map<std::pair<std::size_t, std::size_t>, std::string>;

constexpr std::string_view vtk_head =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"{}\" byte_order=\"LittleEndian\">\n  <{}>\n";

std::string vtm_text(const Snapshot& snapshot, const std::vector<std::string>& bodies,
                     const std::vector<std::string>& participants) {
  std::string text = fmt::format(vtk_head, "vtkMultiBlockDataSet", "1.0", "vtkMultiBlockDataSet");
  std::size_t blocks = 0;
  for (auto file = snapshot.begin(); file != snapshot.end();) {
    const auto body = file->first.first;
    text += fmt::format("    <Block index=\"{}\" name=\"{}\">\n", blocks++,
                        body < bodies.size() ? bodies[body] : "all bodies");
    for (std::size_t set = 0; file != snapshot.end() && file->first.first == body; ++file, ++set)
      text += fmt::format("      <DataSet index=\"{}\" name=\"{}\" file=\"{}\"/>\n", set,
                          participants[file->first.second], file->second);
    text += "    </Block>\n";
  }
  return text + "  </vtkMultiBlockDataSet>\n</VTKFile>\n";
}

/// Whether it is `<name>_<window>.vtm`.
bool is_collection(std::string_view file, const std::string& name) {
  constexpr std::string_view tail = ".vtm";
  if (!file.starts_with(name + "_") || !file.ends_with(tail)) return false;
  const auto window = file.substr(name.size() + 1, file.size() - name.size() - 1 - tail.size());
  return !window.empty() && window.find_first_not_of("0123456789") == std::string_view::npos;
}

}  // namespace

void write_collection(const ResultsDirectory& results, const std::string& name, const std::vector<std::string>& bodies,
                      const std::vector<std::string>& participants, const WindowClock& clock) {
  std::map<std::int64_t, Snapshot> snapshots;
  std::set<std::string> stale;
  for (const auto& entry : fs::directory_iterator(results.file("fields"))) {
    const std::string file = entry.path().filename().string();
    if (is_collection(file, name)) stale.insert(file);
    for (std::size_t p = 0; p < participants.size(); ++p) {
      const auto of = field_name(file, participants[p]);
      if (!of) continue;
      const auto body = std::find(bodies.begin(), bodies.end(), of->body) - bodies.begin();
      snapshots[of->window][{static_cast<std::size_t>(body), p}] = file;
    }
  }
  if (snapshots.empty()) return;
  std::string text = fmt::format(vtk_head, "Collection", "0.1", "Collection");
  for (const auto& [window, snapshot] : snapshots) {
    const auto file = fmt::format("{}_{:08}.vtm", name, window);
    write_atomically(results.file("fields/" + file), vtm_text(snapshot, bodies, participants));
    stale.erase(file);
    text += fmt::format("    <DataSet timestep=\"{:.17g}\" file=\"{}\"/>\n", clock.time_s(window), file);
  }
  write_atomically(results.file("fields/" + name + ".pvd"), text + "  </Collection>\n</VTKFile>\n");
  for (const auto& file : stale) fs::remove(results.file("fields/" + file));
}

}  // namespace ricochet::coupler
