#include "common/base/computer.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <fstream>

namespace ricochet {
namespace {

template <class Function>
Function* found(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  return "";
}

std::string blas() {
  Dl_info library;
  if (void* product = dlsym(RTLD_DEFAULT, "dgemm_"); product == nullptr || dladdr(product, &library) == 0) return "";
  std::error_code error;
  const std::string given = library.dli_fname;
  const std::string file = std::filesystem::canonical(given, error).string();
  auto* config = found<const char*()>("openblas_get_config");
  // A LAPACK may have brought OpenBLAS along, although products come from another library.
  if (file.find("openblas") == std::string::npos || config == nullptr) return error ? given : file;
  std::string text = config();
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

}  // namespace

Computer this_computer() { return {processor(), blas()}; }

void use_one_thread_in_cholmod() {
  if (auto* set = found<void(int)>("openblas_set_num_threads")) set(1);
  if (auto* set = found<void(int)>("omp_set_max_active_levels")) set(0);
}

}  // namespace ricochet
