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

namespace {

/// Bytes of a character of UTF-8 at the beginning of a text that would move the cursor or turn what follows round; 0 if
/// there is none.
std::size_t length_of_control(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  if ((first < ' ' && first != '\n' && first != '\t') || first == 0x7f) return 1;
  const auto begins = [text](std::string_view lead, unsigned char from, unsigned char to) {
    const auto last = text.size() > lead.size() ? static_cast<unsigned char>(text[lead.size()]) : 0;
    return text.starts_with(lead) && from <= last && last <= to;
  };
  if (begins("\xc2", 0x80, 0x9f) || begins("\xd8", 0x9c, 0x9c)) return 2;  // C1; U+061C
  const bool mark = begins("\xe2\x80", 0x8e, 0x8f);                        // U+200E, U+200F
  const bool breaks_or_embeds = begins("\xe2\x80", 0xa8, 0xae);            // U+2028 to U+202E
  const bool isolate = begins("\xe2\x81", 0xa6, 0xa9);                     // U+2066 to U+2069
  return mark || breaks_or_embeds || isolate ? 3 : 0;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string shown;
  while (!text.empty()) {
    const auto control = length_of_control(text);
    shown += control > 0 ? '?' : text.front();
    text.remove_prefix(std::max<std::size_t>(control, 1));
  }
  return shown;
}

std::string with_replaced(std::string_view text, std::initializer_list<std::pair<char, std::string_view>> by) {
  std::string result;
  for (const char c : text) {
    const auto* found = std::find_if(by.begin(), by.end(), [c](const auto& each) { return each.first == c; });
    result += found == by.end() ? std::string_view(&c, 1) : found->second;
  }
  return result;
}

}  // namespace ricochet
