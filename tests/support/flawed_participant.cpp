// flawed_participant FLAW --name NAME --connect ENDPOINT: a mass on a spring, at rest, that breaks one clause of the
// contract of docs/participants.md, or none (`sound`).
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <thread>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"
#include "common/participant/session.hpp"
#include "common/wire/channel.hpp"

namespace ricochet::participant {
namespace {

constexpr std::array<std::string_view, 13> flaws = {
    "sound",  "negative_mass", "exit_code",     "process_dependent", "trial_leaks",
    "drifts", "wrong_work",    "any_version",   "outlives_coupler",  "forgets_its_state",
    "pulls",  "deaf",          "keeps_its_size"};

class Spring : public Participant {
 public:
  explicit Spring(std::string flaw) : flaw_(std::move(flaw)) {}

  Description describe() override {
    Description d;
    d.name = "spring";
    d.role = Role::explicit_solver;
    d.solver = "flawed_participant";
    d.bodies = {"rod"};
    d.interface_body = {0};
    d.interface_position_m = {0.0};
    d.interface_mass_kg = {flaw_ == "negative_mass" ? -mass : mass};
    d.critical_time_step_s = 0.2;
    d.capabilities = {Capability::repeat_window, Capability::reconfigure, Capability::save_state};
    d.record_columns = {"energy_kinetic_j/rod", "energy_interface_j"};
    return d;
  }
  void initialize(const Setup& setup, LinkOutput& output) override {
    dt_ = setup.clock.size_s();
    if (flaw_ == "pulls") stiffness_ = -stiffness_;
    if (flaw_ == "deaf") stiffness_ = 0.0;
    if (flaw_ == "process_dependent") stiffness_ *= 1.0 + 1e-12 * static_cast<double>(getpid());
    output.value = {0.0};
  }
  void synchronise(Integration, const std::vector<double>& link_input, LinkOutput& output) override {
    trial_ = u_;
    find_force(link_input[0], output);
    accept_motion();
  }
  void reconfigure(const Setup& setup) override {
    if (flaw_ != "keeps_its_size") dt_ = setup.clock.size_s();
  }
  void advance(std::int64_t window, const std::vector<double>& link_input, LinkOutput& output) override {
    trial_ = u_ + dt_ * v_ + 0.5 * dt_ * dt_ * a_;
    find_force(link_input[0], output);
    if (flaw_ == "trial_leaks") v_ += 1e-3 * dt_ * trial_force_ / mass;
    if (flaw_ == "drifts") output.value[0] = trial_force_ += 1e-9 * static_cast<double>(window);
  }
  void accept() override {
    v_ += 0.5 * dt_ * a_;
    accept_motion();
    v_ += 0.5 * dt_ * a_;
  }
  void record(std::vector<double>& row) override {
    row.insert(row.end(), {0.5 * mass * v_ * v_, flaw_ == "wrong_work" ? 1.001 * work_ : work_});
  }

  std::string save_state() override {
    Archive out;
    archive(out);
    return out.take();
  }
  void restore_state(std::string_view bytes) override {
    if (flaw_ == "forgets_its_state") return;
    Archive in(bytes, "the state of the spring");
    archive(in);
    in.end();
  }

 private:
  void archive(Archive& a) { a(u_, v_, a_, link_, force_, work_); }
  void find_force(double link, LinkOutput& output) {
    trial_link_ = link;
    output.value = {trial_force_ = stiffness_ * (link - trial_)};
  }
  void accept_motion() {
    work_ += 0.5 * (force_ + trial_force_) * (trial_link_ - link_);
    u_ = trial_;
    link_ = trial_link_;
    force_ = trial_force_;
    a_ = force_ / mass;
  }

  static constexpr double mass = 1.0;
  std::string flaw_;
  double stiffness_ = 100.0, dt_ = 0, u_ = 0, v_ = 0, a_ = 0, link_ = 0, force_ = 0, work_ = 0;
  double trial_ = 0, trial_link_ = 0, trial_force_ = 0;
};

/// `serve` without its care for other versions.
int serve_any_version(Participant& participant, const ServeOptions& options) {
  Session session(participant);
  wire::Channel channel(options.endpoint, wire::read_key(options.key, options.timeout_s));
  wire::Message request, reply;
  session.hello(reply);
  channel.send(reply);
  while (!session.over()) {
    try {
      channel.receive(request, wire::deadline_in(session.timeout_s() > 0 ? session.timeout_s() : 60.0), false);
    } catch (const ProtocolError&) {
      continue;
    }
    if (session.handle(request, reply)) channel.send(reply);
  }
  return 0;
}

int run(const std::string& flaw, int argc, char** argv) {
  const auto options = parse_arguments(argc, argv).options;
  Spring spring(flaw);
  if (flaw != "any_version") {
    const int code = serve(spring, options);
    if (flaw == "outlives_coupler" && code == static_cast<int>(ExitCode::participant)) {
      std::this_thread::sleep_for(std::chrono::hours(1));
    }
    return flaw == "exit_code" && code == 0 ? 1 : code;
  }
  try {
    return serve_any_version(spring, options);
  } catch (const Error& error) {
    return static_cast<int>(error.code());
  }
}

}  // namespace
}  // namespace ricochet::participant

int main(int argc, char** argv) {
  const auto& flaws = ricochet::participant::flaws;
  if (argc < 2 || std::find(flaws.begin(), flaws.end(), argv[1]) == flaws.end()) {
    std::fprintf(stderr, "the first argument must be one of the flaws\n");
    return 2;
  }
  return ricochet::participant::run(argv[1], argc - 1, argv + 1);
}
