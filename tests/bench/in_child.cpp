#include "tests/bench/in_child.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <exception>

#include "common/base/error.hpp"

namespace ricochet::bench {
namespace {

[[noreturn]] void compute_and_send(const std::function<double()>& compute, int pipe_end) {
  try {
    const double result = compute();
    _exit(write(pipe_end, &result, sizeof result) == sizeof result ? 0 : 1);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_scenes: %s\n", error.what());
    _exit(1);
  }
}

}  // namespace

double in_child(const std::function<double()>& compute) {
  int ends[2];
  if (pipe(ends) != 0) throw ParticipantError("cannot open a pipe");
  const pid_t child = fork();
  if (child < 0) throw ParticipantError("cannot start another process");
  if (child == 0) compute_and_send(compute, ends[1]);
  close(ends[1]);
  double result = 0.0;
  const bool received = read(ends[0], &result, sizeof result) == sizeof result;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  if (!received) throw ParticipantError("a computation in a child process failed");
  return result;
}

}  // namespace ricochet::bench
