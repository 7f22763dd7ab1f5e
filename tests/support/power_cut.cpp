// To be preloaded: what a machine has on its disk when the power goes is what was synchronised. At every syncfs, before
// it returns, the folder POWER_CUT_FOLDER is copied to POWER_CUT_DISK.N, N = 1, 2, ...; a test that kills all processes
// then goes on from the last copy, and all that was written since is lost.
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

namespace fs = std::filesystem;

/// File by file: others come and go meanwhile.
void copy_folder(const fs::path& from, const fs::path& to) {
  std::error_code ignored;
  fs::create_directories(to, ignored);
  for (const auto& entry : fs::directory_iterator(from, ignored)) {
    const auto target = to / entry.path().filename();
    if (entry.is_directory(ignored)) {
      copy_folder(entry.path(), target);
    } else {
      fs::copy_file(entry.path(), target, ignored);
    }
  }
}

}  // namespace

extern "C" int syncfs(int) {
  static std::atomic<int> copies{0};
  const char* folder = std::getenv("POWER_CUT_FOLDER");
  const char* disk = std::getenv("POWER_CUT_DISK");
  if (!folder || !disk) return 0;
  const std::string copy = std::string(disk) + "." + std::to_string(++copies), half = copy + ".half";
  copy_folder(folder, half);
  std::error_code ignored;
  fs::rename(half, copy, ignored);
  return 0;
}
