#pragma once

#include <string>

namespace ricochet {

/// Last bits depend on these besides the programs. Empty: not to be found.
struct Computer {
  std::string processor;  ///< the model as /proc/cpuinfo has it
  std::string blas;       ///< OpenBLAS as it names itself, or the file of another library with dgemm_

  friend bool operator==(const Computer&, const Computer&) = default;
};

[[nodiscard]] Computer this_computer();

/// A BLAS with threads sums in another order for each number of them, and slows the short products of this program.
/// CHOLMOD, where it has been compiled with OpenMP, would start four threads for every short loop in its supernodes,
/// whatever processors there are: they then wait for each other half of the time.
void use_one_thread_in_cholmod();

}  // namespace ricochet
