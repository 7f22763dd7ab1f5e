#include "coupler/results/row_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::coupler {
namespace {

constexpr std::chrono::milliseconds flush_interval{200};

/// No link of somebody else's is followed, and nothing is waited for.
int open_for_rows(const std::string& path) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0644);
  if (descriptor < 0) throw_errno(errno, "cannot write " + path);
  struct stat status {};
  if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode)) return descriptor;
  close(descriptor);
  throw ConfigError(fmt::format("cannot write {}: it is no regular file", path));
}

}  // namespace

RowFile::RowFile(std::string path, const std::vector<std::string>& columns, const Beginning& keep)
    : path_(std::move(path)), descriptor_(open_for_rows(path_)), flushed_(std::chrono::steady_clock::now()) {
  try {
    if (keep.bytes > 0) digest_ = require_beginning(path_, keep);
    if (ftruncate(descriptor_, keep.bytes) != 0) throw_errno(errno, "cannot write " + path_);
    if (keep.bytes > 0) return;
    pending_ = fmt::format("{}\n", fmt::join(columns, ","));
    flush();  // a run that dies at once leaves a table without rows, not an empty file
  } catch (...) {
    close(descriptor_);
    throw;
  }
}

RowFile::~RowFile() {
  try {
    flush();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", command_name, error.what());
  }
  close(descriptor_);
}

void RowFile::put(double value) {
  std::array<char, 32> text;  // of at most 24 characters; a format string is read anew for each number
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 17).ptr;
  if (row_begun_) pending_ += ',';
  pending_.append(text.data(), end);
  row_begun_ = true;
}

void RowFile::end_row() {
  pending_ += '\n';
  row_begun_ = false;
  if (std::chrono::steady_clock::now() - flushed_ >= flush_interval) flush();
}

void RowFile::flush() {
  flushed_ = std::chrono::steady_clock::now();
  const std::string rows = std::exchange(pending_, {});
  const auto before = lseek(descriptor_, 0, SEEK_END);
  const int error = write_all(descriptor_, rows);
  if (error == 0) {
    digest_.add(rows);
    return;
  }
  if (before >= 0 && ftruncate(descriptor_, before) != 0)
    std::fprintf(stderr, "%s: %s ends with half a row\n", command_name, path_.c_str());
  throw_errno(error, "cannot write " + path_);
}

Beginning RowFile::so_far() {
  flush();
  return {lseek(descriptor_, 0, SEEK_END), digest_.hex()};
}

}  // namespace ricochet::coupler
