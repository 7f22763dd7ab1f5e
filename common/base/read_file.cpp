#include "common/base/read_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <vector>

#include "common/base/error.hpp"

namespace ricochet {
namespace {

const char* kind_of(mode_t mode) {
  if (S_ISFIFO(mode)) return "a FIFO";
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

void require_regular(const std::string& path, const struct stat& status) {
  if (S_ISREG(status.st_mode)) return;
  throw ConfigError(fmt::format("{} is {}, allowed is a regular file", path, kind_of(status.st_mode)));
}

class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : path_(path) {
    struct stat status {};
    if (stat(path.c_str(), &status) != 0) fail();
    require_regular(path, status);
    descriptor_ = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0) fail();
    if (fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode)) return;
    close(descriptor_);  // it was replaced meanwhile
    require_regular(path, status);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { close(descriptor_); }

  /// Calls f with the first `bytes` of the file, piece by piece; returns how many there were.
  template <class F>
  std::int64_t read_pieces(std::int64_t bytes, const F& f) {
    std::vector<char> piece(std::size_t{1} << 18);
    std::int64_t read_so_far = 0;
    while (read_so_far < bytes) {
      const auto wanted = std::min<std::int64_t>(bytes - read_so_far, static_cast<std::int64_t>(piece.size()));
      const auto count = read(descriptor_, piece.data(), static_cast<std::size_t>(wanted));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail();
      if (count == 0) break;
      f(std::string_view(piece.data(), static_cast<std::size_t>(count)));
      read_so_far += count;
    }
    return read_so_far;
  }

 private:
  [[noreturn]] void fail() const {
    if (errno == ENOENT || errno == ENOTDIR) throw ConfigError(fmt::format("{} is missing", path_));
    throw_errno(errno, "cannot read " + path_);
  }

  std::string path_;
  int descriptor_ = -1;
};

constexpr auto everything = std::numeric_limits<std::int64_t>::max();

}  // namespace

std::string read_file(const std::string& path) {
  std::string text;
  OpenFile(path).read_pieces(everything, [&](std::string_view piece) { text += piece; });
  return text;
}

Sha256 digest_of_file(const std::string& path, std::int64_t bytes) {
  Sha256 digest;
  const auto found = OpenFile(path).read_pieces(bytes, [&](std::string_view piece) { digest.add(piece); });
  if (found == bytes) return digest;
  throw ConfigError(fmt::format("{} has {} bytes, expected at least {}", path, found, bytes));
}

std::string digest_of_file(const std::string& path) {
  Sha256 digest;
  OpenFile(path).read_pieces(everything, [&](std::string_view piece) { digest.add(piece); });
  return digest.hex();
}

}  // namespace ricochet
