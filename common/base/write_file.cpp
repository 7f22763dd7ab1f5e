#include "common/base/write_file.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "common/base/error.hpp"

namespace ricochet {

int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const auto written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

bool write_within(const std::string& path, const std::string& text) {
  const int descriptor = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return false;
  const auto size = lseek(descriptor, 0, SEEK_END);
  bool fits = size >= static_cast<off_t>(text.size()) && lseek(descriptor, 0, SEEK_SET) == 0;
  if (fits) fits = write_all(descriptor, text + std::string(static_cast<std::size_t>(size) - text.size(), ' ')) == 0;
  return close(descriptor) == 0 && fits;
}

int memory_file(std::string_view text) {
  const int descriptor = memfd_create("ricochet text", MFD_CLOEXEC);
  if (descriptor < 0) throw_errno(errno, "cannot create a file in memory");
  int error = write_all(descriptor, text);
  if (error == 0 && lseek(descriptor, 0, SEEK_SET) != 0) error = errno;
  if (error == 0) return descriptor;
  close(descriptor);
  throw_errno(error, "cannot write a file in memory");
}

void write_atomically(const std::string& path, const std::string& text, unsigned mode) {
  const std::string temporary = path + ".part";
  // Exclusive: a file of that name is somebody's.
  const int descriptor = open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (descriptor < 0) throw_errno(errno, "cannot write " + temporary);
  int error = write_all(descriptor, text);
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  std::remove(temporary.c_str());
  throw_errno(error, "cannot write " + path);
}

}  // namespace ricochet
