#include "coupler/processes/launcher.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/close_range.h>
#include <poll.h>
#include <unistd.h>
#include <uv.h>

#include <array>
#include <cctype>
#include <csignal>
#include <cstring>
#include <deque>
#include <fstream>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::coupler {
namespace {

using Milliseconds = std::chrono::milliseconds;
constexpr std::array heard_signals = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};

/// While there is no launcher, nobody hears the request, and it would end this process.
void hold_requests(bool hold) {
  sigset_t requests;
  sigemptyset(&requests);
  sigaddset(&requests, SIGUSR1);
  pthread_sigmask(hold ? SIG_BLOCK : SIG_UNBLOCK, &requests, nullptr);
}

struct Process {
  LaunchRequest request;
  int* events = nullptr;
  uv_process_t handle{};
  uv_pipe_t standard_input{};
  std::int64_t id = 0;
  std::optional<ProcessEnd> end;
};

/// File that no child inherits except as one of those it is given.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() { close(descriptor_); }
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

int open_log(const std::string& path) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (descriptor < 0) throw_errno(errno, "cannot write " + path);
  return descriptor;
}

}  // namespace

std::string ProcessEnd::text() const {
  if (signal == 0) return fmt::format("ended with exit code {}", exit_status);
  const char* abbreviation = sigabbrev_np(signal);
  return fmt::format("was killed by signal {}{}", signal, abbreviation ? fmt::format(" (SIG{})", abbreviation) : "");
}

struct Launcher::Impl {
  uv_loop_t loop{};
  std::array<uv_signal_t, heard_signals.size()> signals{};
  std::deque<Process> processes;  // libuv keeps pointers to the handles
  int interrupted_by = 0;
  int request = 0;  ///< signal
  bool term_asks = false;
  int events = 0;

  [[nodiscard]] const Process* find(const std::string& name) const {
    for (const auto& process : processes) {
      if (process.request.name == name && process.id != 0) return &process;
    }
    return nullptr;
  }
  [[nodiscard]] bool any_running() const {
    for (const auto& process : processes) {
      if (process.id != 0 && !process.end) return true;
    }
    return false;
  }
  void kill_all(int signal) {
    for (auto& process : processes) {
      if (process.id != 0 && !process.end) kill(-static_cast<pid_t>(process.id), signal);
    }
  }
  void spawn(Process& process, int log);
};

Launcher::Launcher() : impl_(std::make_unique<Impl>()) {
  // Files this process inherited must not reach the participants: one of them might be somebody's pipe.
  if (close_range(3, ~0U, CLOSE_RANGE_CLOEXEC) != 0) uv_disable_stdio_inheritance();
  uv_loop_init(&impl_->loop);
  for (std::size_t i = 0; i < heard_signals.size(); ++i) {
    auto& handle = impl_->signals[i];
    uv_signal_init(&impl_->loop, &handle);
    handle.data = impl_.get();
    uv_signal_start(
        &handle,
        [](uv_signal_t* h, int signal) {
          auto* impl = static_cast<Impl*>(h->data);
          if (signal == SIGUSR1 || (signal == SIGTERM && std::exchange(impl->term_asks, false))) {
            if (impl->request != SIGTERM) impl->request = signal;
            return;
          }
          impl->interrupted_by = signal;
          ++impl->events;
        },
        heard_signals[i]);
  }
  hold_requests(false);
  poll();
}

Launcher::~Launcher() {
  stop(Milliseconds(2000));
  hold_requests(true);
  for (auto& signal : impl_->signals) uv_close(reinterpret_cast<uv_handle_t*>(&signal), nullptr);
  for (auto& process : impl_->processes) {
    auto* input = reinterpret_cast<uv_handle_t*>(&process.standard_input);
    if (!uv_is_closing(input)) uv_close(input, nullptr);
  }
  uv_run(&impl_->loop, UV_RUN_DEFAULT);
  uv_loop_close(&impl_->loop);
}

void Launcher::launch(const LaunchRequest& request) {
  const OpenFile log(open_log(request.log_path));  // before there is a process whose handles would be closed
  auto& process = impl_->processes.emplace_back();
  process.request = request;
  process.events = &impl_->events;
  impl_->spawn(process, log.descriptor());
  poll();  // arms the watchers: until then the file descriptor stays silent
}

void Launcher::Impl::spawn(Process& process, int log) {
  std::vector<char*> arguments = {process.request.executable.data()};
  for (auto& argument : process.request.arguments) arguments.push_back(argument.data());
  arguments.push_back(nullptr);

  uv_pipe_init(&loop, &process.standard_input, 0);
  const bool has_key = !process.request.key.empty();
  const OpenFile key(has_key ? memory_file(process.request.key) : -1);
  std::array<uv_stdio_container_t, 4> stdio{};
  stdio[0].flags = static_cast<uv_stdio_flags>(UV_CREATE_PIPE | UV_READABLE_PIPE);
  stdio[0].data.stream = reinterpret_cast<uv_stream_t*>(&process.standard_input);
  for (const std::size_t i : {1, 2}) {
    stdio[i].flags = UV_INHERIT_FD;
    stdio[i].data.fd = log;
  }
  stdio[3].flags = UV_INHERIT_FD;
  stdio[3].data.fd = key.descriptor();
  uv_process_options_t options{};
  options.file = process.request.executable.c_str();
  options.args = arguments.data();
  options.stdio = stdio.data();
  options.stdio_count = static_cast<int>(has_key ? stdio.size() : stdio.size() - 1);
  options.flags = UV_PROCESS_DETACHED;
  options.exit_cb = [](uv_process_t* handle, std::int64_t status, int signal) {
    auto* ended = static_cast<Process*>(handle->data);
    ended->end = ProcessEnd{status, signal};
    ++*ended->events;
    kill(-static_cast<pid_t>(ended->id), SIGKILL);  // its session: children of a wrapper script
    uv_close(reinterpret_cast<uv_handle_t*>(handle), nullptr);
  };
  process.handle.data = &process;
  const int error = uv_spawn(&loop, &process.handle, &options);
  if (error != 0) {
    uv_close(reinterpret_cast<uv_handle_t*>(&process.handle), nullptr);
    throw ParticipantError(fmt::format("participant '{}': cannot start {}: {}", process.request.name,
                                       process.request.executable, uv_strerror(error)));
  }
  process.id = process.handle.pid;
}

int Launcher::file_descriptor() const { return uv_backend_fd(&impl_->loop); }

void Launcher::poll() { uv_run(&impl_->loop, UV_RUN_NOWAIT); }

bool Launcher::wait_all(Milliseconds timeout) {
  return wait_until([this] { return !impl_->any_running(); }, timeout);
}

bool Launcher::wait_for(const std::string& name, Milliseconds timeout) {
  return wait_until([&] { return end_of(name).has_value(); }, timeout);
}

bool Launcher::wait_until(const std::function<bool()>& over, Milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  poll();
  while (!over()) {
    const auto left = std::chrono::duration_cast<Milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    if (left <= 0) return false;
    pollfd wait{file_descriptor(), POLLIN, 0};
    ::poll(&wait, 1, static_cast<int>(std::min<std::int64_t>(left, 1000)));
    poll();
  }
  return true;
}

void Launcher::stop(Milliseconds grace) {
  poll();
  if (!impl_->any_running()) return;
  impl_->kill_all(SIGTERM);
  impl_->kill_all(SIGCONT);  // a stopped process hears SIGTERM only when it goes on
  if (wait_all(grace)) return;
  impl_->kill_all(SIGKILL);
  while (!wait_all(Milliseconds(1000))) {
  }
}

int Launcher::events() const { return impl_->events; }

bool Launcher::launched(const std::string& name) const { return impl_->find(name) != nullptr; }

std::int64_t Launcher::process_id(const std::string& name) const {
  const auto* process = impl_->find(name);
  return process ? process->id : 0;
}

std::optional<ProcessEnd> Launcher::end_of(const std::string& name) const {
  const auto* process = impl_->find(name);
  return process ? process->end : std::nullopt;
}

std::string Launcher::log_path(const std::string& name) const {
  const auto* process = impl_->find(name);
  return process ? process->request.log_path : "";
}

int Launcher::interrupted_by() const { return impl_->interrupted_by; }

void Launcher::take_requests() { impl_->term_asks = true; }

int Launcher::take_request() { return std::exchange(impl_->request, 0); }

std::string last_lines(const std::string& path, std::size_t lines) {
  constexpr std::int64_t most_bytes = 1 << 16;
  constexpr std::size_t longest_line = 400;
  std::ifstream file(path, std::ios::ate);
  const std::int64_t size = file ? static_cast<std::int64_t>(file.tellg()) : 0;
  file.seekg(std::max<std::int64_t>(0, size - most_bytes));
  std::deque<std::string> kept;
  for (std::string line; std::getline(file, line);) {
    const auto says_something = [](unsigned char c) { return std::isalnum(c) || c >= 0x80; };
    if (std::none_of(line.begin(), line.end(), says_something)) continue;  // mpirun rules off what it says
    if (line.size() > longest_line) line = "... " + line.substr(line.size() - longest_line);
    kept.push_back(printable(line));
    if (kept.size() > lines) kept.pop_front();
  }
  std::string text;
  for (const auto& line : kept) text += "    " + line + "\n";
  return text;
}

}  // namespace ricochet::coupler
