#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/base/error.hpp"

/// Common to the fuzz targets. A target defines `LLVMFuzzerTestOneInput`, as libFuzzer wants it: it is called with one
/// input after another, and has to come back from each.
namespace ricochet::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// With RICOCHET_FUZZ_TELL in the environment, why an input was refused: who writes a seed wants to know.
inline void tell(const Error& error) {
  static const bool asked = std::getenv("RICOCHET_FUZZ_TELL") != nullptr;
  if (asked) std::fprintf(stderr, "refused: %s\n", error.what());
}

/// An input may be refused by an error of ours; whatever else is thrown ends the program, which libFuzzer reports.
template <class Read>
int read_or_refuse(Read read) {
  try {
    read();
  } catch (const Error& error) {
    tell(error);
  }
  return 0;
}

/// A file in memory with a path, for readers that want one.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("fuzz", MFD_CLOEXEC)) {
    if (descriptor_ < 0) throw std::runtime_error("memfd_create");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(descriptor_); }

  void hold(std::string_view bytes) {
    const bool held = ftruncate(descriptor_, 0) == 0 &&
                      pwrite(descriptor_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
    if (!held) throw std::runtime_error("a file in memory cannot be written");
  }
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace ricochet::fuzz
