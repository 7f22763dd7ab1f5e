#include "coupler/contract/contract_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/contract/contract_response.hpp"
#include "coupler/contract/contract_run.hpp"
#include "coupler/contract/contract_scene.hpp"
#include "coupler/processes/machine_check.hpp"

namespace ricochet::coupler {
namespace {

/// The clauses, in the order in which they are tried; later ones build on what the first run brought.
class Contract {
 public:
  /// `beside`: what it takes part in; null: it is driven without a scene.
  Contract(const ContractCommand& command, double window_size_s, const ContractScene* beside)
      : command_(command), beside_(beside) {
    drive_.window_size_s = window_size_s;
  }
  bool check();

 private:
  /// A test returns what is worth saying of a clause that is kept.
  using Test = std::function<std::string()>;
  void judge(const std::string& clause, const Test& test);
  /// Runs `test` if the first run went through: there is nothing to compare with otherwise.
  void judge_run(const std::string& clause, const Test& test);
  void judge_beside_ours();
  void say_what_was_not_tried() const;

  void describes_itself();
  void runs_to_the_end();
  void is_deterministic();
  void repeats_a_window();
  void goes_on_from_what_it_saved();
  void takes_another_size();
  void keeps_zero();
  void reports_its_work();
  void refuses_another_version();
  void outlives_no_coupler(bool silent);

  ContractCommand command_;
  const ContractScene* beside_;
  ContractDrive drive_;
  ContractRun first_;
  bool described_ = false, ran_ = false, deterministic_ = false;
  int passed_ = 0, failed_ = 0, skipped_ = 0;
};

void Contract::judge(const std::string& clause, const Test& test) {
  const auto print = [&clause](const char* verdict, const std::string& text) {
    fmt::print("  {:<8} {}{}{}\n", verdict, clause, text.empty() ? "" : ": ", text);
    std::fflush(stdout);
  };
  try {
    const auto text = test();
    ++passed_;
    print("passed", text);
  } catch (const NotApplicable& reason) {
    ++skipped_;
    print("-", reason.why);
  } catch (const Error& error) {
    ++failed_;
    print("FAILED", error.what());
  }
}

void Contract::judge_run(const std::string& clause, const Test& test) {
  judge(clause, [&] {
    if (!ran_) throw NotApplicable{"not tested, it did not come that far"};
    return test();
  });
}

void Contract::judge_beside_ours() {
  judge_run("declares the scene's own masses and places", [this] { return beside_->declares_the_scene(command_); });
  judge_run("answers as the scene's own elements", [this] { return beside_->answers_as_the_elements(command_); });
  judge_run("computes what the shipped solver does",
            [this] { return beside_->computes_what_the_shipped_solver_does(command_, drive_); });
}

void Contract::say_what_was_not_tried() const {
  fmt::print(
      "not tried: {}loads, supports and contact of a whole run, result fields, axial stress\n",
      beside_ ? "" : "masses, places, stiffness and motion beside the shipped solver (--scene SCENE --name NAME), ");
}

bool Contract::check() {
  const auto silent = [this](void (Contract::*test)()) {
    return [this, test]() -> std::string {
      (this->*test)();
      return "";
    };
  };
  const auto with_the_first = [this](auto* test) { return [this, test] { return test(command_, drive_, first_); }; };
  judge("describes itself consistently", silent(&Contract::describes_itself));
  judge(fmt::format("computes {} windows and ends with exit code 0", drive_.windows),
        silent(&Contract::runs_to_the_end));
  judge_run("a second process gives the same bits", silent(&Contract::is_deterministic));
  judge_run("a repeated trial of a window gives the same bits", silent(&Contract::repeats_a_window));
  judge_run("another process goes on from its saved state to the same bits",
            silent(&Contract::goes_on_from_what_it_saved));
  judge_run("told another window size it computes with that", silent(&Contract::takes_another_size));
  judge_run("zero input stays zero", silent(&Contract::keeps_zero));
  judge_run("interface work equals force times motion", silent(&Contract::reports_its_work));
  judge_run("answers unit inputs by a symmetric, positive matrix", with_the_first(respond_like_an_elastic_body));
  judge_run("driven by force it takes the steps of a window", with_the_first(take_substeps));
  judge_run("single steps of a window end like the whole", with_the_first(take_single_substeps));
  judge_run("a stiffness on its interface acts like its force", with_the_first(take_interface_stiffness));
  judge_run("integrates by central differences when it is asked to", with_the_first(switch_integration));
  judge_run("loads and tells its motion", with_the_first(load_their_motion));
  if (beside_) judge_beside_ours();
  judge("refuses another version of the protocol", silent(&Contract::refuses_another_version));
  judge("ends by itself when the coupler dies", [this] {
    outlives_no_coupler(false);
    return std::string();
  });
  judge("ends by itself when the coupler falls silent", [this] {
    outlives_no_coupler(true);
    return std::string();
  });
  fmt::print("{} of {} clauses passed, {} failed, {} not applicable\n", passed_, passed_ + failed_ + skipped_, failed_,
             skipped_);
  say_what_was_not_tried();
  return failed_ == 0;
}

void Contract::describes_itself() {
  ContractPeer peer(command_);
  describe(peer, command_.timeout_s, first_);
  described_ = true;
}

void Contract::runs_to_the_end() {
  if (!described_) throw NotApplicable{"not tested, it did not come that far"};
  first_ = {};
  run_contract(command_, drive_, first_);
  ran_ = true;
}

/// Names the first window at which two runs part.
void require_equal(const ContractRun& a, const ContractRun& b, const std::string& which) {
  using Values = std::vector<double>;
  const auto first_difference = [](const Values& x, const Values& y) -> std::optional<std::size_t> {
    const auto [at, unused] = std::mismatch(x.begin(), x.end(), y.begin(), y.end());
    if (at == x.end() && x.size() == y.size()) return std::nullopt;
    return at - x.begin();
  };
  if (const auto at = first_difference(a.output, b.output)) {
    const auto window = *at / std::max<std::size_t>(a.size(), 1);
    fail(fmt::format("the link output of {} differs from window {} on", which, window));
  }
  if (first_difference(a.velocity, b.velocity) || first_difference(a.acceleration, b.acceleration)) {
    fail(fmt::format("velocities or accelerations of {} differ", which));
  }
  if (const auto at = first_difference(a.records, b.records)) {
    const auto columns = a.description.record_columns.size();
    fail(fmt::format("the history of {} differs from row {} on, column \"{}\"", which, *at / columns,
                     a.description.record_columns[*at % columns]));
  }
}

void Contract::is_deterministic() {
  ContractRun second;
  run_contract(command_, drive_, second);
  require_equal(first_, second, "the second process");
  deterministic_ = true;
}

void Contract::repeats_a_window() {
  if (!first_.description.has(Capability::repeat_window)) {
    throw NotApplicable{"it does not announce \"repeat_window\" (protocol \"kim\" will refuse it)"};
  }
  auto drive = drive_;
  drive.try_first = true;
  ContractRun run;
  run_contract(command_, drive, run);
  if (!run.forgotten.empty()) {
    fail(fmt::format("window {}: the same input, tried again after another one, gives other numbers",
                     run.forgotten.front()));
  }
  if (deterministic_) require_equal(first_, run, "a run with repeated trials");
}

void Contract::goes_on_from_what_it_saved() {
  if (!first_.description.has(Capability::save_state)) {
    throw NotApplicable{"it does not announce \"save_state\" (a run with it makes no checkpoints)"};
  }
  auto drive = drive_;
  drive.save_at = drive.windows / 2;
  ContractRun run;
  run_contract(command_, drive, run);
  if (deterministic_) require_equal(first_, run, fmt::format("a process restored at window {}", drive.save_at));
}

void Contract::takes_another_size() {
  if (!first_.description.has(Capability::reconfigure))
    throw NotApplicable{"it does not announce \"reconfigure\" (time.changes and resume --step will refuse it)"};
  auto drive = drive_;
  drive.begin_with_s = 0.5 * first_.window_size_s;
  ContractRun run;
  run_contract(command_, drive, run);
  double difference = 0.0;
  for (std::size_t i = 0; i < run.output.size(); ++i)
    difference = std::max(difference, std::abs(run.output[i] - first_.output[i]));
  if (difference > 1e-9 * largest(first_.output))
    fail(fmt::format(
        "initialised for windows of {:.6g} s and told {:.6g} s before the first, its link output differs by "
        "{:.6g} from that of one initialised for {:.6g} s, largest value {:.6g}",
        drive.begin_with_s, first_.window_size_s, difference, first_.window_size_s, largest(first_.output)));
}

void Contract::keeps_zero() {
  auto drive = drive_;
  drive.zero_input = true;
  ContractRun run;
  run_contract(command_, drive, run);
  for (const char* energy : {"energy_kinetic_j", "energy_strain_j"}) {
    const auto values = run.column(energy);
    if (!values.empty() && values.front() != 0.0) {
      throw NotApplicable{fmt::format("it does not start at rest ({} {:.6g})", energy, values.front())};
    }
  }
  if (largest(run.column("energy_external_j")) > 0.0) throw NotApplicable{"loads act on it"};
  const double output = std::max({largest(run.first_output), largest(run.output), largest(run.velocity)});
  if (output > 0.0) {
    fail(
        fmt::format("its link output reaches {:.6g}, though no column energy_kinetic_j, energy_strain_j or "
                    "energy_external_j tells of motion or loads",
                    output));
  }
}

/// Explicit: W = sum over windows of 1/2 (P_n + P_n+1) . du, with u the input and P the output. Implicit: the work of
/// -L, with L the input and u the output; it may hold the explicit elements' share of the staggered kinetic energy of
/// the shared nodes, dt^2/8 a . L.
void Contract::reports_its_work() {
  const auto reported = first_.column("energy_interface_j");
  if (reported.empty()) fail("it has no column energy_interface_j: nobody could tell who makes energy in a run");
  const auto& force = first_.implicit() ? first_.input : first_.output;
  const auto& motion = first_.implicit() ? first_.output : first_.input;
  const std::size_t size = first_.size();
  const double sign = first_.implicit() ? -1.0 : 1.0, dt = first_.window_size_s;
  double work = 0.0, scale = 0.0;
  const auto staggered = [&](std::size_t row) {
    double sum = 0.0;
    for (std::size_t i = row * size; i < (row + 1) * size; ++i) sum += first_.acceleration[i] * force[i];
    return 0.125 * dt * dt * sum;
  };
  for (std::size_t row = 1; row < reported.size(); ++row) {
    for (std::size_t i = row * size; i < (row + 1) * size; ++i) {
      const double part = 0.5 * sign * (force[i - size] + force[i]) * (motion[i] - motion[i - size]);
      work += part;
      scale += std::abs(part);
    }
    const double said = reported[row] - reported.front();
    const bool plain = std::abs(said - work) <= 1e-9 * scale;
    if (plain || (first_.implicit() && std::abs(said - work - staggered(row) + staggered(0)) <= 1e-9 * scale)) continue;
    fail(fmt::format("window {}: it reports {:.9g} J, force times motion is {:.9g} J", row, said, work));
  }
}

void Contract::refuses_another_version() {
  ContractPeer peer(command_);
  peer.welcome(peer.meet().participant, command_.timeout_s, wire::protocol_version + 1);
  const auto* answer = peer.hear();
  const int expected = static_cast<int>(ExitCode::protocol);
  if (answer) {
    const bool failed = answer->kind == wire::Kind::failure;
    const auto code = failed ? answer->as<wire::Failure>().error_code : 0;
    if (failed && code == expected) return;
    fail(fmt::format("it answered '{}' with code {} to version {}, expected 'failure' with code {}",
                     wire::name(answer->kind), code, wire::protocol_version + 1, expected));
  }
  const auto end = peer.wait_end();
  if (end->signal != 0 || end->exit_status != expected) {
    fail(fmt::format("it {}, expected 'failure' or exit code {}", end->text(), expected));
  }
}

/// The standard input of the process stays open: what ends it must be the connection, or its deadline.
void Contract::outlives_no_coupler(bool silent) {
  if (!described_) throw NotApplicable{"not tested, it did not come that far"};
  ContractPeer peer(command_);
  auto drive = drive_;
  drive.windows = 3;
  ContractRun run;
  describe(peer, std::min(1.0, 0.2 * command_.timeout_s), run);
  if (ran_) advance(peer, drive, run);
  if (!silent) peer.die();
  const auto end = peer.wait_end();
  if (!end) fail(fmt::format("it still runs {} s later", command_.timeout_s));
  if (end->signal == 0 && end->exit_status == 0) fail("it ended with exit code 0, as if all were well");
}

/// Writes the file that the key interface_nodes of a foreign body reads: a row per node, to the last bit.
void write_interface_nodes(const ContractCommand& command, const std::string& path) {
  ContractPeer peer(command);
  ContractRun run;
  describe(peer, command.timeout_s, run);
  const auto& bodies = run.description.interface_body.data;
  const auto& positions = run.description.interface_position_m;
  if (bodies.empty() || std::count(bodies.begin(), bodies.end(), bodies.front()) != std::ssize(bodies))
    throw ConfigError(
        fmt::format("--interface-nodes: found {} of '{}', allowed: a participant with interface nodes of one body",
                    bodies.empty() ? "no interface node" : "interface nodes of several bodies", run.hello.participant));
  const auto& body = run.description.bodies[static_cast<std::size_t>(bodies.front())];
  std::string text = fmt::format("# interface nodes of \"{}\" [m]\n", body);
  const auto columns = static_cast<std::size_t>(run.description.components);
  for (auto row = positions.data.begin(); row != positions.data.end(); row += static_cast<std::ptrdiff_t>(columns))
    text += fmt::format("{}\n", fmt::join(row, row + static_cast<std::ptrdiff_t>(columns), ", "));
  write_atomically(path, text);
  fmt::print("wrote {}: {} interface node{} of \"{}\"\n", path, bodies.size(), bodies.size() == 1 ? "" : "s", body);
}

}  // namespace

bool check_participant(const ContractRequest& request) {
  ContractCommand command = request.command;
  std::optional<scene::Problem> problem;
  std::optional<ContractScene> beside;
  if (!request.scene.empty()) {
    problem = load_problem(request.scene);
    beside.emplace(*problem, request.name);
    command.words = beside->command(command.words);
  }
  fmt::print("{}\n", fmt::join(command.words, " "));
  if (!request.interface_nodes.empty()) write_interface_nodes(command, request.interface_nodes);
  return Contract(command, request.window_size_s, beside ? &*beside : nullptr).check();
}

}  // namespace ricochet::coupler
