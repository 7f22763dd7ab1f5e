#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

/// The facts that the kernel tells of the processes and sockets of this machine.
namespace ricochet::test {

/// A file of /proc; empty if its process ends meanwhile (the stream turns that error into an end of the text).
inline std::string proc_text(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// Ids of the other processes whose command line contains `text` (arguments separated by blanks). A process that has
/// ended and only waits for its parent has no command line any more.
inline std::vector<pid_t> processes_with(const std::string& text) {
  std::vector<pid_t> found;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ignored)) {
    const std::string id = entry.path().filename().string();
    if (!std::isdigit(static_cast<unsigned char>(id[0]))) continue;
    std::string command = proc_text(entry.path().string() + "/cmdline");
    std::replace(command.begin(), command.end(), '\0', ' ');
    if (command.find(text) != std::string::npos && std::stoi(id) != getpid()) found.push_back(std::stoi(id));
  }
  return found;
}

/// Letter of the kernel for what a process does: 'T' is stopped, 'Z' has ended; 0 if there is none.
inline char process_state(pid_t pid) {
  const std::string text = proc_text("/proc/" + std::to_string(pid) + "/stat");
  const auto end_of_name = text.rfind(") ");
  return end_of_name == std::string::npos ? '\0' : text[end_of_name + 2];
}

/// True if a Unix socket, abstract ones included, has `text` in its name.
inline bool unix_socket_with(const std::string& text) {
  return proc_text("/proc/net/unix").find(text) != std::string::npos;
}

/// Waits for something that becomes true; false if it has not within the timeout.
template <class Condition>
bool wait_until(Condition condition, double timeout_s) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// The most main memory that a process has had so far [bytes]; 0 if it has ended.
inline double peak_memory(pid_t pid) {
  const std::string text = proc_text("/proc/" + std::to_string(pid) + "/status");
  const auto at = text.find("VmHWM:");
  return at == std::string::npos ? 0.0 : 1024.0 * std::stod(text.substr(at + 6));
}

}  // namespace ricochet::test
