// The `ricochet` command; its subcommands stand in command_line.cpp.
#include <cstdio>
#include <exception>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "coupler/command/command_line.hpp"
#include "coupler/run/compute_scene.hpp"

int main(int argc, char** argv) {
  ricochet::prepare_process();
  try {
    return ricochet::coupler::run_command_line(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", ricochet::command_name, ricochet::printable(ricochet::text_of(error)).c_str());
    return ricochet::coupler::exit_code_of(error);
  }
}
