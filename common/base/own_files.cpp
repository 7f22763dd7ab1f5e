#include "common/base/own_files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <climits>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/read_file.hpp"
#include "common/base/write_file.hpp"

namespace ricochet {
namespace {

namespace fs = std::filesystem;

constexpr const char* first_line =
    "# Files that ricochet wrote here; only these it removes or replaces. Name, size, time of the last change [ns].";

/// Digits of a window that fits 64 bits: a number of more was written by nobody of ours.
constexpr std::size_t most_digits = 18;

/// '#' in the pattern stands for digits, at least one and at most so many.
bool matches(std::string_view pattern, std::string_view name, std::size_t most = std::string_view::npos) {
  const auto mark = pattern.find('#');
  if (mark == std::string_view::npos) return pattern == name;
  const auto tail = pattern.substr(mark + 1);
  if (name.size() <= mark + tail.size() || name.substr(0, mark) != pattern.substr(0, mark) || !name.ends_with(tail))
    return false;
  const auto digits = name.substr(mark, name.size() - mark - tail.size());
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  return digits.size() <= most && std::all_of(digits.begin(), digits.end(), is_digit);
}

/// A name in the list, whose lines and columns it must not break: "\\t" stands for a tab, and so on.
std::string listed_form(const std::string& name) {
  return with_replaced(name, {{'\\', "\\\\"}, {'\t', "\\t"}, {'\n', "\\n"}});
}

std::string name_of_listed(std::string_view text) {
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '\\' && i + 1 < text.size();
    if (escape) ++i;
    name += !escape ? text[i] : text[i] == 't' ? '\t' : text[i] == 'n' ? '\n' : text[i];
  }
  return name;
}

/// Found out now, not when the file is to be written at the end of a run.
void require_possible_name(const std::string& folder, const std::string& pattern) {
  const auto file = fs::path(pattern).filename().string();
  const std::size_t bytes = file.size() + (file.find('#') == std::string::npos ? 0 : most_digits - 1);
  if (bytes <= NAME_MAX) return;
  throw ConfigError(
      fmt::format("{}/{}: found a name of {} bytes ('#': {} digits), allowed are {}; give the scene file, or what it "
                  "names so, a shorter name",
                  folder, pattern, bytes, most_digits, NAME_MAX));
}

/// A path below the folder: a list that somebody else made must not lead out of it.
bool stays_below(const std::string& name) {
  const fs::path path(name);
  const auto leads_up = [](const fs::path& part) { return part == ".."; };
  return !name.empty() && path.is_relative() && std::none_of(path.begin(), path.end(), leads_up);
}

/// Without following links: where a folder is one, what lies in it is not ours.
bool folders_are_real(const fs::path& folder, const fs::path& name) {
  fs::path at = folder;
  std::error_code error;
  for (const auto& part : name.parent_path()) {
    at /= part;
    const auto status = fs::symlink_status(at, error);
    if (fs::exists(status) && !fs::is_directory(status)) return false;
  }
  return true;
}

}  // namespace

OwnFiles::OwnFiles(std::string folder) : folder_(std::move(folder)) { read(); }

OwnFiles::~OwnFiles() {
  try {
    seal();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", command_name, error.what());
  }
}

void OwnFiles::read() {
  const auto path = folder_ + "/" + list_name;
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return;
  std::istringstream file(read_file(path));
  const auto refuse = [&](const std::string& line) {
    throw ConfigError(
        fmt::format("{}: found the line \"{:.80}\", which is none of a list of this program; remove it, or give "
                    "another folder with --out DIR",
                    path, line));
  };
  std::string line;
  if (!std::getline(file, line) || line != first_line) refuse(line);
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string name;
    Stamp stamp;
    if (!std::getline(words, name, '\t') || !(words >> stamp.size >> stamp.time_ns)) refuse(line);
    name = name_of_listed(name);
    if (!stays_below(name)) refuse(line);
    listed_[name] = stamp;
  }
}

OwnFiles::Stamp OwnFiles::stamp_of(const std::string& name) const {
  struct stat status {};
  if (lstat((folder_ + "/" + name).c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  return {status.st_size, status.st_mtim.tv_sec * 1'000'000'000LL + status.st_mtim.tv_nsec};
}

OwnFiles::Owner OwnFiles::owner_of(const std::string& name, Changed changed) const {
  struct stat status {};
  if (lstat((folder_ + "/" + name).c_str(), &status) != 0) return Owner::nobody;
  if (!S_ISREG(status.st_mode) || !folders_are_real(folder_, name)) return Owner::somebody_else;
  for (const auto& [pattern, stamp] : listed_) {
    const bool as_written = stamp == Stamp{} || stamp == stamp_of(name) || changed == Changed::accepted;
    if (matches(pattern, name, most_digits) && as_written) return Owner::us;
  }
  return Owner::somebody_else;
}

bool OwnFiles::is_kept(const std::string& name) const {
  return std::any_of(kept_.begin(), kept_.end(), [&](const auto& path) {
    std::error_code ignored;
    return fs::equivalent(fs::path(folder_) / name, path, ignored);
  });
}

/// All that lies there and bears a name that the pattern means.
std::vector<std::string> OwnFiles::present(const std::string& pattern) const {
  struct stat status {};
  if (pattern.find('#') == std::string::npos) {
    return lstat((folder_ + "/" + pattern).c_str(), &status) == 0 ? std::vector{pattern} : std::vector<std::string>{};
  }
  std::vector<std::string> found;
  std::error_code ignored;
  const auto parent = fs::path(pattern).parent_path();
  for (const auto& entry : fs::directory_iterator(fs::path(folder_) / parent, ignored)) {
    const auto name = (parent / entry.path().filename()).string();
    if (matches(pattern, name)) found.push_back(name);
  }
  return found;
}

void OwnFiles::claim(const std::vector<std::string>& names, Changed changed) {
  std::vector<std::string> all = names;
  for (const auto& name : names) all.push_back(name + ".part");
  for (const auto& pattern : all) {
    require_possible_name(folder_, pattern);
    for (const auto& name : present(pattern)) {
      if (is_kept(name)) {
        throw ConfigError(
            fmt::format("{}/{} is read by this command, which would write a file of that name; give another folder "
                        "with --out DIR",
                        folder_, name));
      }
      if (owner_of(name, changed) != Owner::somebody_else) continue;
      throw ConfigError(
          fmt::format("{}/{} is there already, and ricochet did not write it, or it was changed since; move it away, "
                      "or give another folder with --out DIR",
                      folder_, name));
    }
  }
  for (const auto& name : all) listed_[name] = {};
  claimed_.insert(claimed_.end(), all.begin(), all.end());
  write();
}

void OwnFiles::remove_all() {
  std::error_code ignored;
  std::vector<std::string> names;
  for (const auto& [pattern, stamp] : listed_) {
    for (const auto& name : present(pattern)) {
      if (owner_of(name) == Owner::us && !is_kept(name)) names.push_back(name);
    }
  }
  for (const auto& name : names) {
    fs::remove(fs::path(folder_) / name, ignored);
    const auto parent = fs::path(name).parent_path();
    if (!parent.empty()) fs::remove(fs::path(folder_) / parent, ignored);  // only if it is empty
  }
  std::erase_if(listed_, [this](const auto& entry) {
    const bool ours_now = std::find(claimed_.begin(), claimed_.end(), entry.first) != claimed_.end();
    return !ours_now && present(entry.first).empty();
  });
  write();
}

void OwnFiles::remove_halves() {
  std::error_code ignored;
  for (const auto& pattern : claimed_) {
    if (!pattern.ends_with(".part")) continue;
    for (const auto& name : present(pattern)) fs::remove(fs::path(folder_) / name, ignored);
  }
}

/// An empty list is none.
void OwnFiles::write() const {
  std::string text = fmt::format("{}\n", first_line);
  for (const auto& [name, stamp] : listed_)
    text += fmt::format("{}\t{}\t{}\n", listed_form(name), stamp.size, stamp.time_ns);
  const auto path = folder_ + "/" + list_name;
  std::error_code ignored;
  fs::remove(path + ".part", ignored);  // of a process that was killed while it wrote the list
  if (listed_.empty()) fs::remove(path, ignored);
  if (!listed_.empty()) write_atomically(path, text);
}

void OwnFiles::seal() {
  if (claimed_.empty()) return;
  std::error_code ignored;
  for (const auto& pattern : claimed_) {
    listed_.erase(pattern);
    for (const auto& name : present(pattern)) {
      const bool half = name.ends_with(".part");
      if (half) fs::remove(fs::path(folder_) / name, ignored);
      if (!half) listed_[name] = stamp_of(name);
    }
  }
  claimed_.clear();
  write();
}

}  // namespace ricochet
