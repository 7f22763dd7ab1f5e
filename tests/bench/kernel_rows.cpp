#include "tests/bench/kernel_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "tests/bench/process_run.hpp"
#include "tests/bench/reference_scene.hpp"
#include "tests/support/places.hpp"

namespace ricochet::bench {

Kernels::Kernels(const std::string& folder, const std::vector<int>& refinements, int repeats)
    : refinements_(refinements) {
  const std::string path = folder + "/kernels.json";
  run_command({test::build_folder() + "/bench_kernels",
               fmt::format("--benchmark_filter=^(triad|multiply_add)|/({})(/real_time)?$", fmt::join(refinements, "|")),
               fmt::format("--benchmark_repetitions={}", repeats), "--benchmark_enable_random_interleaving=true",
               "--benchmark_min_time=0.02", "--benchmark_out_format=json", "--benchmark_out=" + path},
              folder + "/kernels.log");
  std::ifstream file(path);
  const auto json = nlohmann::json::parse(file);
  for (const auto& run : json.at("benchmarks")) {
    if (run.at("run_type") != "iteration" || run.value("error_occurred", false)) continue;
    const auto name = run.at("run_name").get<std::string>();
    auto& kernel = kernels_[name.substr(0, name.find("/real_time"))];
    kernel.time_s.push_back(1e-9 * run.at("real_time").get<double>());
    kernel.bytes = run.value("bytes", 0.0);
    kernel.flops = run.value("flops", 0.0);
  }
  for (const auto& [name, kernel] : kernels_) {
    if (name.rfind("triad/", 0) == 0) triads_[kernel.bytes] = kernel;
  }
}

const Kernels::Kernel& Kernels::at(const std::string& kernel, int refinement) const {
  return kernels_.at(fmt::format("{}/{}", kernel, refinement));
}

std::vector<double> Kernels::bandwidth(double bytes) const {
  const auto distance = [bytes](const auto& triad) { return std::abs(std::log(triad.first / bytes)); };
  const auto nearest = std::min_element(triads_.begin(), triads_.end(),
                                        [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return quotients(std::vector<double>(nearest->second.time_s.size(), nearest->first), nearest->second.time_s);
}

std::vector<double> Kernels::peak_flops() const {
  const auto& kernel = kernels_.at("multiply_add");
  return quotients(std::vector<double>(kernel.time_s.size(), kernel.flops), kernel.time_s);
}

std::vector<double> Kernels::bound_s(const std::string& kernel, int refinement) const {
  const auto& of = at(kernel, refinement);
  const auto bytes_s = bandwidth(of.bytes), flops_s = peak_flops();
  std::vector<double> bound;
  for (std::size_t i = 0; i < flops_s.size(); ++i) {
    bound.push_back(std::max(of.bytes / bytes_s[i], of.flops / flops_s[i]));
  }
  return bound;
}

std::string Kernels::machine() const {
  const double largest = triads_.rbegin()->first;
  return fmt::format("one thread: {:.1f} GB/s (triad of {:.0f} MB), {:.0f} Gflop/s", 1e-9 * median(bandwidth(largest)),
                     1e-6 * largest, 1e-9 * median(peak_flops()));
}

std::vector<Row> Kernels::rows() const {
  std::vector<Row> rows;
  for (const int n : refinements_) {
    const std::string mesh = mesh_name(n);
    const auto against = [&](const char* label, const char* other, const char* ours, std::optional<Level> level) {
      rows.push_back({label, mesh, quotients(at(other, n).time_s, at(ours, n).time_s), level});
    };
    against("K u: element by element / explicit kernel", "element_by_element", "stiffness_product", Level{false, 2.0});
    against("K u: Eigen's sparse product / explicit kernel", "sparse_product", "stiffness_product", {});
    against("K u, unstructured: element by element / explicit kernel", "unstructured_element_by_element",
            "unstructured_product", Level{false, 3.0});
    against("K u, unstructured: Eigen's sparse product / explicit kernel", "unstructured_sparse_product",
            "unstructured_product", {});
    against("K u of solids: element by element / explicit kernel", "solid_element_by_element", "solid_product",
            Level{false, 2.0});
    against("K u of solids: Eigen's sparse product / explicit kernel", "solid_sparse_product", "solid_product", {});
    against("solve: CHOLMOD simplicial / condensed factor", "cholmod_simplicial", "condensed_solve", {});
    against("solve: CHOLMOD supernodal / condensed factor", "cholmod_supernodal", "condensed_solve", {});
    const auto by_two = [&](const char* label, const std::string& kernel) {
      if (kernels_.count(fmt::format("{}_by_two/{}", kernel, n)) == 0) {
        rows.push_back({label, mesh, {}, {}, "one processor"});
      } else {
        rows.push_back({label, mesh, quotients(at(kernel, n).time_s, at(kernel + "_by_two", n).time_s), {}});
      }
    };
    by_two("K u: one thread / two", "stiffness_product");
    by_two("K u of solids: one thread / two", "solid_product");
    by_two("solve: one thread / two", "condensed_solve");
    const auto against_bound = [&](const char* label, const char* kernel) {
      rows.push_back({label, mesh, quotients(bound_s(kernel, n), at(kernel, n).time_s), {}});
    };
    against_bound("explicit kernel: element-steps per second / bound", "stiffness_product");
    against_bound("condensed factor: solves per second / bound", "condensed_solve");
  }
  return rows;
}

}  // namespace ricochet::bench
