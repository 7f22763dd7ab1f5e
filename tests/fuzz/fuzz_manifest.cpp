// The reader of a checkpoint's manifest, with the files that it may name beside it.
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "coupler/results/checkpoint.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

/// A folder with one cut, whose manifest is replaced by the input; it goes when the program ends.
struct Folder {
  Folder() {
    std::string pattern = "/dev/shm/ricochet_fuzz_XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp");
    path = pattern;
    std::ofstream(path + "/7.state") << "abc";
    std::ofstream(path + "/7.implicit.state") << "abc";
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
  std::string path;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ricochet;
  static const Folder folder;
  std::ofstream(folder.path + "/7.json", std::ios::binary) << fuzz::text_of(data, size);
  return fuzz::read_or_refuse([] {
    std::vector<std::string> damaged;
    (void)coupler::CheckpointFolder(folder.path).last(damaged);
  });
}
