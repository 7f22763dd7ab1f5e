// bench_scenes [--out DIR] [--repeats N] [--steps N] [--refinements N,...]: measures the benchmarks of the README in
// interleaved repeats, prints one table of ratios and writes DIR/bench.csv.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "tests/bench/kernel_rows.hpp"
#include "tests/bench/scene_rows.hpp"

namespace ricochet::bench {
namespace {

struct Options {
  std::string out = "out/bench";
  int repeats = 5;
  long steps = 400;
  std::vector<int> refinements = {1, 2, 4};
};

void define(CLI::App& app, Options& options) {
  app.description("Ratios of times, measured in one run: medians of interleaved repeats.");
  app.add_option("--out", options.out, "Results folder")->capture_default_str();
  app.add_option("--repeats", options.repeats, "How often everything is measured")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  app.add_option("--steps", options.steps, "Steps of the reference scene; multiple of 4")
      ->capture_default_str()
      ->check(CLI::Range(4L, 568L))
      ->check([](const std::string& text) { return std::stol(text) % 4 == 0 ? "" : "not a multiple of 4"; });
  app.add_option("--refinements", options.refinements, "Meshes: 1 is 0.5 mm, 2 is 0.25 mm, ...")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::IsMember({1, 2, 4}));
}

std::string load_average() {
  double loads[1] = {0.0};
  return getloadavg(loads, 1) == 1 ? fmt::format("{:.1f}", loads[0]) : "unknown";
}

void measure(const Options& options) {
  std::filesystem::create_directories(options.out);
  const std::string folder = std::filesystem::absolute(options.out).string();
  const std::string load = load_average();
  const Kernels kernels(folder, options.refinements, options.repeats);
  SceneRuns scenes(folder, options.refinements, options.steps);
  Exchanges exchanges(folder);
  for (int repeat = 1; repeat <= options.repeats; ++repeat) {
    fmt::print(stderr, "\rrepeat {} of {}", repeat, options.repeats);
    scenes.repeat();
    exchanges.repeat();
  }
  fmt::print(stderr, "\n");
  std::vector<Row> rows = scenes.rows(kernels);
  for (const auto& more : {exchanges.rows(), kernels.rows()}) rows.insert(rows.end(), more.begin(), more.end());
  write_atomically(folder + "/bench.csv", to_csv(rows));
  fmt::print("{}\n{} repeats, {} steps, mu = 0.1; {}; load {} at the start, {} at the end\nwrote {}/bench.csv\n",
             to_text(rows), options.repeats, options.steps, kernels.machine(), load, load_average(), options.out);
}

}  // namespace
}  // namespace ricochet::bench

int main(int argc, char** argv) {
  using namespace ricochet;
  CLI::App app;
  bench::Options options;
  bench::define(app, options);
  try {
    app.parse(argc, argv);
    auto& meshes = options.refinements;  // growth counts from the coarsest, each once
    std::sort(meshes.begin(), meshes.end());
    meshes.erase(std::unique(meshes.begin(), meshes.end()), meshes.end());
    bench::measure(options);
    return 0;
  } catch (const CLI::ParseError& error) {  // --help, too
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::config);
  } catch (const Error& error) {
    fmt::print(stderr, "bench_scenes: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_scenes: {}\n", error.what());
    return 1;
  }
}
