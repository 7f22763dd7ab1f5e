#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/table.hpp"

namespace ricochet::bench {

/// The times that `bench_kernels` measured.
class Kernels {
 public:
  /// Runs it; its repetitions are interleaved at random. Its JSON goes into `folder`.
  Kernels(const std::string& folder, const std::vector<int>& refinements, int repeats);

  /// Kernels against plain ways to do the same, and against the machine's bound.
  [[nodiscard]] std::vector<Row> rows() const;
  /// Least time of a kernel on this machine [s]: max(bytes / bandwidth, flops / peak), the bandwidth that of a triad
  /// which touches about as many bytes, from the same cache or memory. Per repeat.
  [[nodiscard]] std::vector<double> bound_s(const std::string& kernel, int refinement) const;
  /// The times of a kernel, per repeat.
  [[nodiscard]] const std::vector<double>& times_s(const std::string& kernel, int refinement) const {
    return at(kernel, refinement).time_s;
  }
  /// Bandwidth of the largest triad and peak flops, for the head of the table.
  [[nodiscard]] std::string machine() const;

 private:
  struct Kernel {
    std::vector<double> time_s;
    double bytes = 0.0, flops = 0.0;
  };
  [[nodiscard]] const Kernel& at(const std::string& kernel, int refinement) const;
  [[nodiscard]] std::vector<double> bandwidth(double bytes) const;
  [[nodiscard]] std::vector<double> peak_flops() const;

  std::vector<int> refinements_;
  std::map<std::string, Kernel> kernels_;  ///< by google-benchmark's name: "triad/262144"
  std::map<double, Kernel> triads_;        ///< by the bytes they touch
};

}  // namespace ricochet::bench
