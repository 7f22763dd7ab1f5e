// The `ricochet` command:
//   ricochet run SCENE [--out DIR] | check SCENE | stability SCENE | study STUDY | report DIR |
//            init NAME | check-participant -- COMMAND ... | --version
#include <csignal>
#include <cstdio>
#include <exception>

#include "coupler/command_line.hpp"
#include "coupler/run.hpp"

int main(int argc, char** argv) {
  // A closed pipe behind `ricochet run | head` must not end a run whose results go to files.
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return ricochet::coupler::run_command_line(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ricochet: %s\n", error.what());
    return ricochet::coupler::exit_code_of(error);
  }
}
