// The states that a run saves between windows, and goes on from.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <utility>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/run/coupled_run.hpp"

namespace ricochet::coupler {

/// Those of the shipped solvers need nothing; of others it is enough to know it before it matters.
void CoupledRun::prepare_checkpoints(const std::vector<PeerDescription>& descriptions) {
  for (const auto& description : descriptions) {
    if (description.has(Capability::save_state)) continue;
    if (scene_.checkpoint.asked || from_) require_capability(description, Capability::save_state, "checkpoints");
    return;
  }
  const auto names = participant_names(scene_);
  checkpoints_.emplace(
      scene_.checkpoint, results_.file("checkpoint"),
      from_ ? FieldDigests(results_.path(), names, from_->window, from_->fields) : FieldDigests(results_.path(), names),
      set_.launcher());
  programs_ = programs_of(problem_, descriptions, executables_, coupling_->links());
}

/// Reads or writes what this process goes on from between windows; the participants' own is beside it.
void CoupledRun::archive(Archive& a) {
  a(*coupling_, *protocol_, *loop_, *history_, tally_, *watch_, outside_, since_last_row_.contact_iterations,
    since_last_row_.contact_residual, forces_told_);
  if (axial_stress_) a(*axial_stress_);
  if (probes_) a(*probes_);
}

void CoupledRun::restore() {
  std::vector<std::string> parts;
  for (const auto& link : coupling_->links()) {
    const auto part = std::find_if(from_->parts.begin(), from_->parts.end(),
                                   [&](const auto& one) { return one.participant == link.name(); });
    if (part == from_->parts.end())
      throw ConfigError(fmt::format("the checkpoint has no part of participant '{}'", link.name()));
    parts.push_back(part->bytes);
  }
  Archive in(from_->coupler, "the coupler's part of the checkpoint");
  WindowClock clock;  // which resume_run has looked at
  std::vector<Program> began;
  in(clock, began);
  require_same(began, programs_);
  coupling_->restore_states(parts);
  archive(in);
  in.end();
}

void CoupledRun::save_if_due(std::int64_t window) {
  if (!checkpoints_) return;
  const auto due = checkpoints_->due(window);
  if (due == Checkpoints::Due::no) return;
  save(window);
  if (due != Checkpoints::Due::last) return;
  if (checkpoints_->settle() == window)
    summary_.notes.push_back(
        fmt::format("`{} resume {}` goes on from window {}", command_name, results_.path(), window));
  throw Interrupted(SIGTERM);
}

/// Begins a checkpoint: all participants answer at the end of the same accepted window.
void CoupledRun::save(std::int64_t window) {
  Checkpoint checkpoint{scene_.path,
                        scene_.sha256,
                        scene_.coupling.protocol.name,
                        window,
                        problem_.clock.time_s(window),
                        history_file_.so_far(),
                        probe_file_ ? probe_file_->so_far() : Beginning{},
                        {},
                        wall_s(),
                        cpu_spent_s(),
                        stepping_s(),
                        {},
                        {}};
  auto states = coupling_->save_states();
  for (std::size_t p = 0; p < states.size(); ++p)
    checkpoint.parts.push_back({coupling_->links()[p].name(), std::move(states[p])});
  Archive out;
  WindowClock clock = problem_.clock;
  out(clock, programs_);
  archive(out);
  checkpoint.coupler = out.take();
  checkpoints_->begin(std::move(checkpoint));
}

}  // namespace ricochet::coupler
