#include "tests/support/one_process.hpp"

#include <chrono>
#include <utility>

#include "common/participant/session.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/run/time_loop.hpp"
#include "explicit_solver/explicit_solver.hpp"
#include "implicit_solver/implicit_solver.hpp"
#include "tests/support/all_rows.hpp"

namespace ricochet::test {

/// A solver and its end of the conversation.
class LocalParticipant {
 public:
  LocalParticipant(const scene::Problem& problem, const scene::ParticipantSpec& spec) : spec_(spec) {
    if (spec.role == scene::Role::implicit_solver) {
      solver_ = std::make_unique<implicit_solver::ImplicitSolver>(problem, spec.name);
    } else {
      solver_ = std::make_unique<explicit_solver::ExplicitSolver>(problem, spec.name);
    }
    session_ = std::make_unique<participant::Session>(*solver_);
    session_->hello(answer_);
    wire::Message welcome;
    welcome.make<wire::Welcome>();
    welcome.as<wire::Welcome>().participant = spec.name;
    welcome.as<wire::Welcome>().timeout_s = problem.scene.coupling.timeout_s;
    ask(welcome);
  }
  void ask(wire::Message& request) {
    request.version = wire::protocol_version;
    request.run_id = "one process";
    request.sequence = sequence_++;
    session_->handle(request, answer_);
    if (!session_->over()) session_->work_ahead();
  }
  [[nodiscard]] coupler::PeerDescription description() {
    wire::Message request;
    request.make<wire::Describe>();
    ask(request);
    return {answer_.as<wire::Description>(), spec_.name, spec_.role};
  }
  /// Once initialised.
  void compute_all_rows() {
    if (auto* solver = dynamic_cast<explicit_solver::ExplicitSolver*>(solver_.get())) test::compute_all_rows(*solver);
  }
  [[nodiscard]] coupler::Peer peer() {
    return {spec_.name, [this](wire::Message& request) { ask(request); },
            [this]() -> wire::Message& { return answer_; }};
  }

 private:
  scene::ParticipantSpec spec_;
  std::unique_ptr<participant::Participant> solver_;
  std::unique_ptr<participant::Session> session_;
  wire::Message answer_;
  std::int64_t sequence_ = 0;
};

namespace {

std::unique_ptr<coupler::Coupling> couple(std::vector<std::unique_ptr<LocalParticipant>>& participants,
                                          WindowClock clock) {
  std::vector<coupler::PeerDescription> descriptions;
  std::vector<coupler::Peer> peers;
  for (auto& participant : participants) {
    descriptions.push_back(participant->description());
    peers.push_back(participant->peer());
  }
  return std::make_unique<coupler::Coupling>(std::move(peers), descriptions, std::move(clock));
}

}  // namespace

OneProcess::OneProcess(const std::string& scene_path, bool all_rows)
    : problem_(scene::build_problem(scene::load_scene(scene_path))), plan_(scene::plan(problem_)) {
  const auto& scene = problem_.scene;
  for (const auto& spec : scene.participants) {
    participants_.push_back(std::make_unique<LocalParticipant>(problem_, spec));
  }
  coupling_ = couple(participants_, problem_.clock);
  protocol_ = coupler::make_protocol(scene.coupling.protocol.name, coupler::protocol_settings(scene.coupling));
  wire::Initialize initialize = coupler::initialize_request(problem_, plan_.windows, "");
  initialize.fields_every = 0;  // no result files: there is no folder for them
  protocol_->start(*coupling_, initialize);
  for (auto& participant : participants_)
    if (all_rows) participant->compute_all_rows();
}

OneProcess::~OneProcess() = default;

double OneProcess::run(std::function<void(std::int64_t)> on_records) {
  const auto& coupling = problem_.scene.coupling;
  const coupler::LoopSettings settings{plan_.windows, coupling.resynchronise_every, coupling.protocol.coupled(), false};
  coupler::TimeLoop loop(*coupling_, *protocol_, settings, std::move(on_records));
  const auto begin = std::chrono::steady_clock::now();
  loop.run();
  const std::chrono::duration<double> stepping = std::chrono::steady_clock::now() - begin;
  return stepping.count() / static_cast<double>(loop.window());
}

double run_in_one_process(const std::string& scene_path, bool all_rows) {
  OneProcess run(scene_path, all_rows);
  return run.run([&run](std::int64_t) {
    for (auto& link : run.coupling().links()) static_cast<void>(link.take_records());
  });
}

}  // namespace ricochet::test
