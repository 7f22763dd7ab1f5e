// mpirun -n 2 build/bench_ranks [--solid] [--elements N] [--deep N] [--ranks N,...] [--latency_us T] [--bandwidth_gb_s
// B] Cost of a window of all_explicit in many ranks, computed from what is measured here: the scene is shared
// out among so many ranks, and single ones of them are stepped in this process with nobody to talk to. Messages are
// counted with the latency and the bandwidth of two processes of this machine, or with those of a network that are
// given.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "explicit_solver/ranks/rank.hpp"
#include "explicit_solver/stepping.hpp"
#include "tests/bench/rank_scene.hpp"
#include "tests/bench/table.hpp"

namespace ricochet::bench {
namespace {

using Clock = std::chrono::steady_clock;
using explicit_solver::SharedPart;

double since_s(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

struct Network {
  double latency_s = 0.0, bandwidth_b_s = 0.0;
};

/// Half of a round trip of so many bytes between ranks 0 and 1, the median of some.
double one_way_s(int rank, int bytes) {
  constexpr int trips = 2000;
  std::vector<char> buffer(static_cast<std::size_t>(bytes));
  std::vector<double> times;
  for (int trip = 0; trip < trips; ++trip) {
    const auto begin = Clock::now();
    for (const int sender : {0, 1}) {
      if (rank == sender) MPI_Send(buffer.data(), bytes, MPI_BYTE, 1 - rank, 0, MPI_COMM_WORLD);
      if (rank != sender) MPI_Recv(buffer.data(), bytes, MPI_BYTE, 1 - rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    times.push_back(0.5 * since_s(begin));
  }
  return median(times);
}

Network measure_network(int rank) {
  constexpr int little = 8, much = 1 << 20;
  const double latency_s = one_way_s(rank, little), long_s = one_way_s(rank, much);
  return {latency_s, (much - little) / (long_s - latency_s)};
}

/// For a rank that is stepped alone: notes when its messages begin to go out and when they are waited for.
class NobodyThere final : public explicit_solver::Communicator {
 public:
  NobodyThere(int rank, int count) : rank_(rank), count_(count) {}
  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return count_; }
  void broadcast(std::string&) override {}
  void broadcast(void*, int) override {}
  void gather(const std::vector<double>&, const std::vector<int>&, std::vector<double>&) override {}
  [[nodiscard]] std::vector<std::string> gather(const std::string&) override { return {}; }
  [[nodiscard]] std::string scatter(const std::vector<std::string>&) override { return {}; }
  [[nodiscard]] bool any(bool own) override { return own; }
  void start(const std::vector<Message>&, std::vector<Message>& in) override {
    begin_ = Clock::now();
    messages += static_cast<double>(in.size());
    for (const auto& message : in) bytes += static_cast<double>(sizeof(double) * message.values.size());
  }
  void finish() override { meanwhile_s += since_s(begin_); }

  double meanwhile_s = 0.0, messages = 0.0, bytes = 0.0;  ///< of all exchanges so far

 private:
  int rank_, count_;
  Clock::time_point begin_;
};

/// The cost of one rank, a window.
struct RankCost {
  int nodes = 0;
  double computes_s = 0.0, meanwhile_s = 0.0;  ///< all of it; what of it is done while messages are on their way
  double messages = 0.0, bytes = 0.0;          ///< that come in

  [[nodiscard]] double window_s(const Network& network) const {
    const double exchange_s = messages * network.latency_s + bytes / network.bandwidth_b_s;
    return computes_s - meanwhile_s + std::max(meanwhile_s, exchange_s);
  }
};

/// Every row moves from the start. The nodes of other ranks stay where they are, as if they were held.
RankCost cost_of(const scene::Problem& problem, const std::vector<SharedPart>& shared, int rank, int ranks) {
  constexpr int least_windows = 20, repeats = 5;
  constexpr double least_s = 0.05;
  NobodyThere others(rank, ranks);
  explicit_solver::RankShare share(problem, problem.scene.participants.front(), shared,
                                   participant::Drive::displacement, others);
  RankCost cost;
  for (auto& state : share.states()) {
    state.v.setRandom();
    cost.nodes += static_cast<int>(std::count(state.own.begin(), state.own.end(), true));
  }
  participant::Setup setup;
  setup.clock = problem.clock.size_s();
  std::optional<explicit_solver::ExplicitContact> contact;
  if (rank == 0)
    contact.emplace(problem.scene.contact_law(), solver::ContactSurface(problem, share.states()), setup.clock,
                    solver::SlidingRows(problem, share.states()));
  explicit_solver::Stepping stepping(share.states(), setup, std::move(contact));
  stepping.synchronise(0, {});
  std::int64_t window = 0;
  const auto step = [&] {
    ++window;
    stepping.advance(window, {});
    stepping.accept(window);
    stepping.work_ahead(window + 1);
  };
  for (int i = 0; i < least_windows; ++i) step();
  std::vector<double> computes, meanwhile;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    others.meanwhile_s = others.messages = others.bytes = 0.0;
    const auto begin = Clock::now();
    int windows = 0;
    while (windows < least_windows || since_s(begin) < least_s) {
      step();
      ++windows;
    }
    computes.push_back(since_s(begin) / windows);
    meanwhile.push_back(others.meanwhile_s / windows);
    cost.messages = others.messages / windows;
    cost.bytes = others.bytes / windows;
  }
  cost.computes_s = median(computes);
  cost.meanwhile_s = median(meanwhile);
  return cost;
}

int fullest(const std::vector<SharedPart>& shared, int ranks) {
  std::vector<int> blocks(static_cast<std::size_t>(ranks), 0);
  for (const auto& part : shared) {
    for (const int rank : part.rank_of_block) ++blocks[static_cast<std::size_t>(rank)];
  }
  return static_cast<int>(std::max_element(blocks.begin(), blocks.end()) - blocks.begin());
}

/// Among the first rank, the fullest and three others that whose window takes longest.
RankCost slowest(const scene::Problem& problem, const std::vector<SharedPart>& shared, int ranks,
                 const Network& network) {
  RankCost found;
  for (const int rank : std::set<int>{0, fullest(shared, ranks), ranks / 4, ranks / 2, 3 * ranks / 4}) {
    const RankCost cost = cost_of(problem, shared, rank, ranks);
    if (cost.window_s(network) > found.window_s(network)) found = cost;
  }
  return found;
}

void compute(const RankScene& choice, const std::vector<int>& counts, const Network& network,
             const std::string& folder) {
  constexpr int orders = 3;  // a window of all_explicit: advance, accept, work ahead
  std::filesystem::create_directories(folder);
  const auto problem = scene::build_problem(scene::load_scene(write_rank_scene(choice, folder + "/ranks.toml")));
  const auto whole = solver::initial_states(problem, problem.scene.participants.front(), false);
  fmt::print("{} elements; latency {:.2f} us, bandwidth {:.1f} GB/s\n",
             problem.bodies.front().mesh.elements.size() + problem.bodies.back().mesh.elements.size(),
             1e6 * network.latency_s, 1e-9 * network.bandwidth_b_s);
  fmt::print("{:>6} {:>9} {:>9} {:>10} {:>14} {:>15} {:>12} {:>12} {:>9} {:>11}\n", "ranks", "nodes", "messages",
             "bytes", "computes [us]", "meanwhile [us]", "orders [us]", "window [us]", "speed-up", "efficiency");
  double alone_s = 0.0;
  for (const int ranks : counts) {
    const RankCost cost = slowest(problem, explicit_solver::share_out(problem, whole, {}, 1, ranks), ranks, network);
    const double orders_s = orders * std::ceil(std::log2(ranks)) * network.latency_s;
    const double window_s = cost.window_s(network) + orders_s;
    if (ranks == counts.front()) alone_s = window_s * counts.front();
    fmt::print("{:>6} {:>9} {:>9.0f} {:>10.0f} {:>14.1f} {:>15.1f} {:>12.1f} {:>12.1f} {:>9.2f} {:>11.2f}\n", ranks,
               cost.nodes, cost.messages, cost.bytes, 1e6 * cost.computes_s, 1e6 * cost.meanwhile_s, 1e6 * orders_s,
               1e6 * window_s, alone_s / window_s, alone_s / window_s / ranks);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace ricochet::bench

int main(int argc, char** argv) {
  using namespace ricochet;
  MPI_Init(&argc, &argv);
  int rank = 0, processes = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &processes);
  CLI::App app("What a window of all_explicit would take in many ranks.");
  bench::RankScene choice{.elements = 4000, .deep = 125};
  std::vector<int> counts = {1, 2, 10, 100, 1000};
  double latency_us = 0.0, bandwidth_gb_s = 0.0;
  std::string folder = "out/ranks";
  app.add_flag("--solid", choice.solid, "Hexahedra");
  app.add_option("--elements", choice.elements, "Across")->capture_default_str()->check(CLI::PositiveNumber);
  app.add_option("--deep", choice.deep, "Along the impact, of each body")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--ranks", counts, "What the first takes is the measure of the others")
      ->delimiter(',')
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--latency_us", latency_us, "Of a message of a network; without it, of this machine");
  app.add_option("--bandwidth_gb_s", bandwidth_gb_s, "Of a network; without it, of this machine");
  app.add_option("--folder", folder, "For the scene")->capture_default_str();
  int code = 0;
  try {
    app.parse(argc, argv);
    bench::Network network{1e-6 * latency_us, 1e9 * bandwidth_gb_s};
    if (latency_us <= 0.0 || bandwidth_gb_s <= 0.0) {
      if (processes != 2) throw ConfigError("to measure this machine's messages, start it by mpirun -n 2");
      const auto measured = bench::measure_network(rank);
      if (latency_us <= 0.0) network.latency_s = measured.latency_s;
      if (bandwidth_gb_s <= 0.0) network.bandwidth_b_s = measured.bandwidth_b_s;
    }
    if (rank == 0) bench::compute(choice, counts, network, folder);
  } catch (const CLI::ParseError& error) {
    code = rank == 0 ? app.exit(error) : error.get_exit_code();
  } catch (const std::exception& error) {
    if (rank == 0) fmt::print(stderr, "bench_ranks: {}\n", error.what());
    code = 1;
  }
  MPI_Finalize();
  return code;
}
