#include <cstdio>
#include <exception>

#include "common/problem/problem.hpp"
#include "coupler/results/history_file.hpp"
#include "tests/support/merged_history.hpp"

/// Writes history.csv of a scene whose solvers run in this process.
int main(int argc, char** argv) try {
  if (argc != 3) return std::fputs("usage: one_process_history SCENE FILE\n", stderr), 2;
  const auto rows = ricochet::test::rows_of(argv[1]);
  const auto problem = ricochet::scene::build_problem(ricochet::scene::load_scene(argv[1]));
  ricochet::coupler::HistoryFile file(argv[2], ricochet::coupler::history_shape(problem));
  for (const auto& row : rows) file.add(row);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
