// bench_scenes [--out DIR] [--repeats N] [--steps N] [--refinements N,...] [--only GROUP,...]: measures the benchmarks
// of docs/speed.md in interleaved repeats, prints one table of ratios and writes DIR/bench.csv, DIR/calculix.csv and
// .svg.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "tests/bench/busy_rows.hpp"
#include "tests/bench/calculix.hpp"
#include "tests/bench/checkpoint_rows.hpp"
#include "tests/bench/contact_growth_rows.hpp"
#include "tests/bench/flood_rows.hpp"
#include "tests/bench/kernel_rows.hpp"
#include "tests/bench/memory_rows.hpp"
#include "tests/bench/rank_rows.hpp"
#include "tests/bench/rounded_striker_rows.hpp"
#include "tests/bench/scene_rows.hpp"
#include "tests/bench/set_up_rows.hpp"
#include "tests/bench/thread_rows.hpp"
#include "tests/bench/tied_rows.hpp"
#include "tests/bench/turning_rows.hpp"

namespace ricochet::bench {
namespace {

struct Options {
  std::string out = "out/bench";
  int repeats = 5;
  long steps = 400;
  std::vector<int> refinements = {1, 2, 4};
  std::vector<std::string> only = {"scenes",  "busy",     "set-up",  "striker",    "contact", "contact-windows",
                                   "memory",  "exchange", "flood",   "checkpoint", "threads", "ranks",
                                   "turning", "tied",     "kernels", "calculix"};
  [[nodiscard]] bool wants(const char* group) const { return std::find(only.begin(), only.end(), group) != only.end(); }
};

constexpr long calculix_steps = 50;  // it takes a hundred times as long as we do, and more

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
  app.add_option("--only", options.only, "Groups to measure; rows against the machine's bound need scenes and kernels")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::IsMember(options.only));
}

std::string load_average() {
  double loads[1] = {0.0};
  return getloadavg(loads, 1) == 1 ? fmt::format("{:.1f}", loads[0]) : "unknown";
}

/// The rows that the options want.
class Measurements {
 public:
  explicit Measurements(const Options& options) : folder_(std::filesystem::absolute(options.out).string()) {
    if (options.wants("kernels")) kernels_.emplace(folder_, options.refinements, options.repeats);
    if (options.wants("scenes")) scenes_.emplace(folder_, options.refinements, options.steps);
    if (options.wants("busy")) busy_.emplace(folder_, options.steps);
    if (options.wants("set-up")) set_ups_.emplace(folder_);
    if (options.wants("striker")) striker_.emplace(folder_);
    if (options.wants("contact")) contacts_.emplace(folder_);
    if (options.wants("contact-windows")) contact_windows_.emplace(folder_);
    if (options.wants("memory")) memory_.emplace(folder_);
    if (options.wants("exchange")) exchanges_.emplace(folder_);
    if (options.wants("flood")) floods_.emplace(folder_, options.steps);
    if (options.wants("checkpoint")) checkpoints_.emplace(folder_, options.refinements, options.steps);
    if (options.wants("threads")) threads_.emplace(folder_, options.refinements, options.steps);
    if (options.wants("ranks")) ranks_.emplace(folder_, options.steps);
    if (options.wants("turning")) turning_.emplace(folder_);
    if (options.wants("tied")) tied_.emplace(folder_);
    if (options.wants("calculix")) calculix_.emplace(folder_, std::min(options.steps, calculix_steps));
  }
  void repeat() {
    if (scenes_) scenes_->repeat();
    if (busy_) busy_->repeat();
    if (set_ups_) set_ups_->repeat();
    if (striker_) striker_->repeat();
    if (contacts_) contacts_->repeat();
    if (contact_windows_) contact_windows_->repeat();
    if (memory_) memory_->repeat();
    if (exchanges_) exchanges_->repeat();
    if (floods_) floods_->repeat();
    if (checkpoints_) checkpoints_->repeat();
    if (threads_) threads_->repeat();
    if (ranks_) ranks_->repeat();
    if (turning_) turning_->repeat();
    if (tied_) tied_->repeat();
    if (calculix_) calculix_->repeat();
  }
  [[nodiscard]] std::vector<Row> rows() const {
    std::vector<Row> rows;
    const auto add = [&rows](const std::vector<Row>& more) { rows.insert(rows.end(), more.begin(), more.end()); };
    if (scenes_) add(scenes_->rows(kernels_ ? &*kernels_ : nullptr));
    if (busy_) add(busy_->rows());
    if (set_ups_) add(set_ups_->rows());
    if (striker_) add(striker_->rows());
    if (contacts_) add(contacts_->rows());
    if (contact_windows_) add(contact_windows_->rows());
    if (memory_) add(memory_->rows());
    if (exchanges_) add(exchanges_->rows());
    if (floods_) add(floods_->rows());
    if (checkpoints_) add(checkpoints_->rows());
    if (threads_) add(threads_->rows());
    if (ranks_) add(ranks_->rows());
    if (turning_) add(turning_->rows());
    if (tied_) add(tied_->rows());
    if (calculix_) add(calculix_->rows());
    if (kernels_) add(kernels_->rows());
    return rows;
  }
  /// Writes the files; returns their names.
  [[nodiscard]] std::vector<std::string> write() const {
    write_atomically(folder_ + "/bench.csv", to_csv(rows()));
    std::vector<std::string> names = {"bench.csv"};
    if (calculix_) {
      for (const auto& name : calculix_->write_picture()) names.push_back(name);
    }
    return names;
  }
  [[nodiscard]] std::string machine() const { return kernels_ ? kernels_->machine() + "; " : ""; }

 private:
  std::string folder_;
  std::optional<Kernels> kernels_;
  std::optional<SceneRuns> scenes_;
  std::optional<BusyMachine> busy_;
  std::optional<SetUps> set_ups_;
  std::optional<RoundedStriker> striker_;
  std::optional<ContactGrowth> contacts_;
  std::optional<ContactWindows> contact_windows_;
  std::optional<Memory> memory_;
  std::optional<Exchanges> exchanges_;
  std::optional<Floods> floods_;
  std::optional<CheckpointCosts> checkpoints_;
  std::optional<ThreadRuns> threads_;
  std::optional<RankRuns> ranks_;
  std::optional<TurningDiscs> turning_;
  std::optional<TiedBars> tied_;
  std::optional<CalculixRuns> calculix_;
};

void measure(const Options& options) {
  std::filesystem::create_directories(options.out);
  const std::string load = load_average();
  Measurements measurements(options);
  for (int repeat = 1; repeat <= options.repeats; ++repeat) {
    fmt::print(stderr, "\rrepeat {} of {}", repeat, options.repeats);
    measurements.repeat();
  }
  fmt::print(stderr, "\n");
  const auto files = measurements.write();
  fmt::print("{}\n{} repeats, {} steps, mu = 0.1; {}load {} at the start, {} at the end\nwrote {} in {}\n",
             to_text(measurements.rows()), options.repeats, options.steps, measurements.machine(), load, load_average(),
             fmt::join(files, ", "), options.out);
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
