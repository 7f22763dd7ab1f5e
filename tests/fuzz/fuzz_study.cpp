// The reader of study files. The scene that a study names stands beside it: "scene".
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "coupler/study/study_file.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

/// A folder with a scene and the study, which goes when the program ends.
struct Folder {
  Folder() {
    std::string pattern = "/dev/shm/ricochet_fuzz_XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp");
    path = pattern;
    std::ofstream(path + "/scene.toml")
        << "model = \"bar\"\n[[contact]]\nname = \"one\"\n[[contact]]\nname = \"two\"\n";
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
  const std::string path = folder.path + "/study.toml";
  std::ofstream(path, std::ios::binary) << fuzz::text_of(data, size);
  return fuzz::read_or_refuse([&] {
    const auto study = coupler::load_study(path);
    (void)coupler::varied_keys(study);
    for (const auto& variation : study.variations) (void)coupler::telling_keys(variation);
  });
}
