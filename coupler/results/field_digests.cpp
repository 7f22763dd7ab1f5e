#include "coupler/results/field_digests.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <sstream>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/read_file.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::coupler {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t hex_digits = 64;

}  // namespace

std::optional<FieldName> field_name(std::string_view file, std::string_view participant) {
  constexpr std::string_view tail = ".vtu";
  if (!file.starts_with(participant) || !file.ends_with(tail)) return std::nullopt;
  file.remove_prefix(participant.size());
  file.remove_suffix(tail.size());
  const auto before = file.rfind('_');
  if (before == std::string_view::npos || before == 1 || (before > 1 && file.front() != '.')) return std::nullopt;
  FieldName name{0, std::string(before == 0 ? "" : file.substr(1, before - 1))};
  const auto number = file.substr(before + 1);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), name.window);
  const bool whole = error == std::errc() && end == number.data() + number.size() && number.front() != '-';
  return whole && name.body.find('.') == std::string::npos ? std::optional(name) : std::nullopt;
}

FieldDigests::FieldDigests(std::string results, std::vector<std::string> participants)
    : results_(std::move(results)), participants_(std::move(participants)) {}

FieldDigests::FieldDigests(std::string results, std::vector<std::string> participants, std::int64_t window,
                           const Beginning& list)
    : FieldDigests(std::move(results), std::move(participants)) {
  window_ = window;
  bytes_ = list.bytes;
  if (list.bytes > 0) digest_ = require_beginning(results_ + "/" + list_name, list);
}

std::string FieldDigests::lines_until(std::int64_t window) const {
  std::vector<std::pair<std::int64_t, std::string>> found;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(results_ + "/fields", none)) {
    const auto file = entry.path().filename().string();
    for (const auto& participant : participants_) {
      const auto of = field_name(file, participant);
      if (of && of->window > window_ && of->window <= window) found.emplace_back(of->window, file);
    }
  }
  std::sort(found.begin(), found.end());
  std::string lines;
  for (const auto& [of, file] : found)
    lines += fmt::format("{}  fields/{}\n", digest_of_file(results_ + "/fields/" + file), file);
  return lines;
}

/// Files that a failed attempt may have left behind the list go.
Beginning FieldDigests::take(std::int64_t window) {
  const auto lines = lines_until(window);
  const auto path = results_ + "/" + list_name;
  if (lines.empty() && bytes_ == 0) return {};
  std::error_code exists_already;
  fs::create_directories(fs::path(path).parent_path(), exists_already);
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0644);
  if (descriptor < 0) throw_errno(errno, "cannot write " + path);
  int error = ftruncate(descriptor, bytes_) == 0 && lseek(descriptor, bytes_, SEEK_SET) == bytes_ ? 0 : errno;
  if (error == 0) error = write_all(descriptor, lines);
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error != 0) throw_errno(error, "cannot write " + path);
  digest_.add(lines);
  bytes_ += static_cast<std::int64_t>(lines.size());
  window_ = std::max(window_, window);
  return {bytes_, digest_.hex()};
}

void FieldDigests::require(const std::string& results, const Beginning& list) {
  if (list.bytes == 0) return;
  const auto path = results + "/" + list_name;
  static_cast<void>(require_beginning(path, list));
  std::istringstream lines(read_file(path).substr(0, static_cast<std::size_t>(list.bytes)));
  for (std::string line; std::getline(lines, line);) {
    if (line.size() <= hex_digits + 2) throw ConfigError(fmt::format("{} has the line \"{:.80}\"", path, line));
    const auto field = results + "/" + line.substr(hex_digits + 2);
    if (digest_of_file(field) != line.substr(0, hex_digits))
      throw ConfigError(fmt::format("{} is not what was written: it has another SHA-256 than {} says", field, path));
  }
}

}  // namespace ricochet::coupler
