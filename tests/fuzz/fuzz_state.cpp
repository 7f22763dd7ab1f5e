// The state of a solver, as a checkpoint keeps it. The first byte says of which solver; what it accepts it computes a
// window from.
#include "tests/fuzz/small_solvers.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ricochet;
  static fuzz::SmallSolvers solvers;
  if (size == 0) return 0;
  auto& solver = solvers.all()[data[0] % solvers.all().size()];
  solver.participant->restore_state(solver.state);  // whatever the input before has left
  return fuzz::read_or_refuse([&] {
    solver.participant->restore_state(fuzz::text_of(data + 1, size - 1));
    (void)solver.participant->save_state();
    fuzz::SmallSolvers::run(solver, 3);
  });
}
