#include "common/base/user_key.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>

#include "common/base/write_file.hpp"

namespace ricochet {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t key_bytes = 32;

fs::path folder_of_state() {
  const auto absolute_path_in = [](const char* variable) {
    const char* value = std::getenv(variable);
    const fs::path path(value ? value : "");
    return path.is_absolute() ? path : fs::path();
  };
  if (const auto state = absolute_path_in("XDG_STATE_HOME"); !state.empty()) return state / "ricochet";
  const auto home = absolute_path_in("HOME");
  return home.empty() ? home : home / ".local/state/ricochet";
}

/// Empty if it is not there, or not this user's alone.
std::string read_key(const fs::path& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return "";
  struct stat status {};
  const bool private_file = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == geteuid() &&
                            (status.st_mode & (S_IRWXG | S_IRWXO)) == 0;
  std::string key(key_bytes + 1, '\0');
  const auto count = private_file ? read(descriptor, key.data(), key.size()) : -1;
  close(descriptor);
  if (count != static_cast<ssize_t>(key_bytes)) return "";
  key.resize(key_bytes);
  return key;
}

/// Whole at once, and not if another process was faster: under a name of its own first.
void make_key(const fs::path& path) {
  std::array<char, key_bytes> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return;
  const std::string own = fmt::format("{}.{}", path.string(), getpid());
  const int descriptor = open(own.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0) return;
  const bool written = write_all(descriptor, {bytes.data(), bytes.size()}) == 0 && fsync(descriptor) == 0;
  close(descriptor);
  std::error_code ignored;
  if (written) fs::create_hard_link(own, path, ignored);  // which fails where another one's is
  unlink(own.c_str());
}

}  // namespace

std::string user_key() {
  const auto folder = folder_of_state();
  if (folder.empty()) return "";
  const auto path = folder / "key";
  if (auto key = read_key(path); !key.empty()) return key;
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  mkdir(folder.c_str(), 0700);
  make_key(path);
  return read_key(path);
}

}  // namespace ricochet
