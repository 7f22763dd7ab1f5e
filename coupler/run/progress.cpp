#include "coupler/run/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "common/base/process.hpp"

namespace ricochet::coupler {

Progress::Progress(std::int64_t last_window, bool has_contact)
    : last_window_(last_window),
      has_contact_(has_contact),
      terminal_(isatty(STDERR_FILENO) == 1),
      begin_(Clock::now()),
      shown_(begin_) {}

bool Progress::due() {
  const auto now = Clock::now();
  if (now - shown_ < (terminal_ ? std::chrono::milliseconds(100) : std::chrono::milliseconds(2000))) return false;
  shown_ = now;
  return true;
}

void Progress::put(const std::string& line) {
  open_ = terminal_;
  std::fputs(terminal_ ? ("\r\033[K" + line).c_str() : (line + "\n").c_str(), stderr);
  std::fflush(stderr);
}

void Progress::show_start(const std::string& name, std::string_view doing, double share_done) {
  if (!due()) return;
  std::string line = fmt::format("set-up: '{}' {}", name, printable(std::string(doing)));
  if (share_done >= 0.0) line += fmt::format(", {:.0f} %", 100.0 * share_done);
  put(line);
}

void Progress::show(std::int64_t window, const WindowClock& clock, const HistoryRow& row) {
  if (!due()) return;
  const double elapsed = std::chrono::duration<double>(shown_ - begin_).count();
  const double left =
      window > 0 ? elapsed * static_cast<double>(last_window_ - window) / static_cast<double>(window) : 0.0;
  std::string line = fmt::format("step {}/{}  t {:.4g} s  dt {:.4g} s", window, last_window_, clock.time_s(window),
                                 clock.size_s(window + 1));
  if (has_contact_) {
    line += fmt::format("  stick/slip/open {:.0f}/{:.0f}/{:.0f}", row.contact.pairs_stick, row.contact.pairs_slip,
                        row.contact.pairs_open);
  }
  line += fmt::format("  energy {:+.2e}  at most {:.0f} s left", row.energy_error, left);
  put(line);
}

void Progress::close() {
  if (open_) std::fputs("\r\033[K", stderr);
  open_ = false;
}

}  // namespace ricochet::coupler
