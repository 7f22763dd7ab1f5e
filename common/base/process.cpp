#include "common/base/process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "common/base/error.hpp"

namespace ricochet {

void prepare_process() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // The lowest free number is the one that `open` takes.
    if (fcntl(descriptor, F_GETFD) < 0 && open("/dev/null", O_RDWR) < 0) _exit(static_cast<int>(ExitCode::machine));
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void require_descriptors(unsigned long needed) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= needed) return;
  const rlimit wanted{std::min<rlim_t>(needed, limit.rlim_max), limit.rlim_max};
  if (wanted.rlim_cur == needed && setrlimit(RLIMIT_NOFILE, &wanted) == 0) return;
  throw MachineError(fmt::format("this process may have {} files open, it needs {}: raise the limit (ulimit -n)",
                                 limit.rlim_cur, needed));
}

std::string machine_name() {
  if (const char* node = std::getenv("SLURMD_NODENAME")) return node;
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

void require_proc() {
  if (access("/proc/self/fd", R_OK | X_OK) == 0) return;
  throw MachineError(
      fmt::format("cannot read /proc/self/fd: {} (errno {}); ricochet needs /proc", std::strerror(errno), errno));
}

std::string printable(std::string_view text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
    const bool control_of_two_bytes = c == 0xc2 && next >= 0x80 && next < 0xa0;  // C1 in UTF-8
    if (control_of_two_bytes) ++i;
    const bool control = (c < ' ' && c != '\n' && c != '\t') || c == 0x7f || control_of_two_bytes;
    shown += control ? '?' : text[i];
  }
  return shown;
}

}  // namespace ricochet
