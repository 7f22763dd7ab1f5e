#include "tests/support/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace ricochet::test {
namespace {

void redirect(const std::string& path, int descriptor) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) _exit(126);
  dup2(file, descriptor);
  close(file);
}

}  // namespace

std::string file_text(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

Process::Process(std::vector<std::string> command, const std::string& stdout_path, const std::string& stderr_path) {
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ > 0) return;
  setpgid(0, 0);
  redirect(stdout_path, STDOUT_FILENO);
  redirect(stderr_path, STDERR_FILENO);
  std::vector<char*> arguments;
  for (auto& word : command) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());
  _exit(127);
}

Process::~Process() {
  if (pid_ <= 0 || exited_) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

bool Process::running() {
  poll();
  return !exited_;
}

int Process::wait(double timeout_s) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (running() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return exited_ ? code_ : -1;
}

void Process::poll() {
  int status = 0;
  if (exited_ || waitpid(pid_, &status, WNOHANG) != pid_) return;
  exited_ = true;
  code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

Outcome run_command(const std::vector<std::string>& command, const std::string& scratch_folder, double timeout_s) {
  const std::string out = scratch_folder + "/stdout.txt", error = scratch_folder + "/stderr.txt";
  Process process(command, out, error);
  Outcome outcome;
  outcome.code = process.wait(timeout_s);
  outcome.out = file_text(out);
  outcome.error = file_text(error);
  return outcome;
}

}  // namespace ricochet::test
