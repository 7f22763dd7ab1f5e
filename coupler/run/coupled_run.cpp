#include "coupler/run/coupled_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/scene/protocols.hpp"
#include "coupler/processes/interrupted.hpp"
#include "coupler/processes/participants.hpp"
#include "coupler/processes/run_id.hpp"
#include "coupler/watch/conserved.hpp"

namespace ricochet::coupler {
namespace {

Summary first_summary(const scene::Problem& problem, const scene::Plan& plan) {
  const auto& scene = problem.scene;
  Summary summary;
  summary.scene_path = scene.path;
  summary.scene_sha256 = scene.sha256;
  summary.protocol = scene.coupling.protocol.name;
  summary.transport = scene.coupling.transport;
  summary.run_id = make_run_id();
  summary.windows_planned = plan.windows;
  summary.added_mass_kg = plan.added_mass_kg;
  summary.added_mass_share = plan.added_mass_share;
  if (scene.coupling.protocol.dual) summary.substeps = scene.substeps().most;
  summary.clock = problem.clock;
  for (const auto& body : problem.scene.bodies) {
    for (const auto& [name, m] : body.materials())
      if (std::isfinite(m.yield_stress_pa) || std::isfinite(m.strength_pa))
        summary.limits.push_back({name, m.yield_stress_pa, m.strength_pa});
  }
  return summary;
}

}  // namespace

CoupledRun::CoupledRun(scene::Problem& problem, const scene::Plan& plan, const std::vector<std::string>& executables,
                       const ResultsDirectory& results, const Checkpoint* from)
    : problem_(problem),
      scene_(problem.scene),
      plan_(plan),
      executables_(executables),
      results_(results),
      from_(from),
      summary_(first_summary(problem, plan)),
      tally_(tally_of(problem)),
      history_file_(results.file("history.csv"), history_shape(problem), from ? from->history : Beginning{}),
      progress_(plan.windows, !problem.contacts.empty()),
      set_(make_process_set(problem, plan.participants, executables, results, summary_.run_id)),
      outside_(problem) {
  reserve_summary();
}

void CoupledRun::run() {
  try {
    phases();
  } catch (const EnergyGrowth&) {
    throw;
  } catch (const Error& error) {
    if (error.code() != ExitCode::unstable || !loop_) throw;
    // A participant's word on its own overflow knows nothing of steps, penalties and protocols.
    throw SolverError(fmt::format("{}; {}", error.what(), likely_cause(suspicion_, 0.0, 0.0)));
  }
}

void CoupledRun::phases() {
  auto mark = Clock::now();
  const auto lap = [&mark](double& phase_s) {
    const auto now = Clock::now();
    phase_s = std::chrono::duration<double>(now - mark).count();
    mark = now;
  };
  start();
  lap(summary_.phases.start_s);
  setup();
  lap(summary_.phases.setup_s);
  stepping_ = Clock::now();
  step();
  summary_.phases.stepping_s = stepping_s();
  mark = Clock::now();
  finish();
  lap(summary_.phases.finish_s);
  summary_.status = outside_.found().empty() ? RunStatus::done : RunStatus::left_model;
  write_files();
}

void CoupledRun::start() {
  set_.peers().on_progress([this](const std::string& name, std::string_view doing, double share_done) {
    progress_.show_start(name, doing, share_done);
  });
  set_.launch();
  set_.meet();
}

void CoupledRun::setup() {
  auto descriptions = set_.describe();
  check_contact_owner(problem_, descriptions);
  check_capabilities(scene_.coupling.protocol, descriptions);
  for (const auto& description : descriptions)
    if (problem_.clock.changes())
      require_capability(description, Capability::reconfigure, "a run whose windows change their size");
  compare_with_scene(descriptions);
  check_declared_steps(problem_, descriptions);
  std::vector<History::Source> sources, stress_sources;
  for (const auto& description : descriptions) {
    sources.push_back({description.participant, description.record_columns});
    stress_sources.push_back({description.participant, description.axial_stress_columns});
  }
  const auto left_out = untold(problem_, descriptions);
  note_untold(left_out);
  prepare_watch(descriptions, left_out);
  history_ = std::make_unique<History>(sources, scene_.body_names(), conserved_by(problem_), scene_.contact_names(),
                                       ToldBalances{left_out.energy.empty(), left_out.momentum.empty()});
  summary_.interface_known = history_->tells_interface();
  if (scene_.output.axial_stress_every > 0) {
    axial_stress_ = std::make_unique<AxialStress>(stress_sources, scene_.body_names());
  }
  prepare_probes(descriptions);
  coupling_ = std::make_unique<Coupling>(set_.peers().all(), joined(problem_, descriptions), problem_.clock);
  protocol_ = make_protocol(scene_.coupling.protocol.name, protocol_settings(scene_.coupling));
  protocol_->start(*coupling_, initialize_request(problem_, plan_.windows, results_.file("fields")));
  try_links();
  LoopSettings settings{plan_.windows, scene_.coupling.resynchronise_every, scene_.coupling.protocol.coupled(),
                        may_switch(),  outside_.watches_overlaps(),         scene_.checkpoint.every_windows};
  if (const auto& time = scene_.time; time.flight_step_s)
    settings.flight = FlightSteps{*time.step_s, *time.flight_step_s, time.end_s, &problem_.clock};
  loop_ = std::make_unique<TimeLoop>(
      *coupling_, *protocol_, settings, [this](std::int64_t window) { take_records(window); },
      [this](std::int64_t window) {
        compare_first_windows();
        save_if_due(window);
      });
  prepare_checkpoints(descriptions);
  if (from_) {
    restore();
  } else {
    prepare_first_windows();
  }
}

/// Programs of somebody else's only: shipped solvers read what this would compare them with.
void CoupledRun::compare_with_scene(std::vector<PeerDescription>& descriptions) {
  comparisons_.resize(descriptions.size());
  for (std::size_t p = 0; p < descriptions.size(); ++p) {
    if (!scene_.participants[p].foreign() || !SceneComparison::possible(problem_, descriptions[p])) continue;
    comparisons_[p].emplace(problem_, descriptions[p]);
    comparisons_[p]->check_description();
    descriptions[p].scene_position_m = comparisons_[p]->scene_places();
  }
}

void CoupledRun::try_links() {
  for (std::size_t p = 0; p < comparisons_.size(); ++p) {
    if (comparisons_[p]) comparisons_[p]->try_link(coupling_->links()[p], scene_.participants[p].substeps);
    if (from_) comparisons_[p].reset();  // its first row was looked at by the run before
  }
}

void CoupledRun::prepare_first_windows() {
  if (!scene_.coupling.protocol.coupled()) return;
  for (std::size_t p = 0; p < comparisons_.size(); ++p) {
    if (!comparisons_[p]) continue;
    const double critical_s = plan_.participants[p].critical_time_step_s;
    auto beside =
        FirstWindows::of(problem_, *coupling_, coupling_->links()[p], std::isfinite(critical_s) ? critical_s : 0.0);
    if (beside) first_windows_.push_back(std::move(beside));
  }
}

/// Until the implicit participant goes on explicitly, or windows have another size: what it is asked then the shipped
/// solver is not.
void CoupledRun::compare_first_windows() {
  const bool other_size = problem_.clock.size_s(loop_->window() + 1) != problem_.clock.size_s(1);
  if (!loop_->switches().empty() || other_size) first_windows_.clear();
  for (const auto& beside : first_windows_) beside->look();
  const auto over = [](const auto& beside) { return beside->over(); };
  first_windows_.erase(std::remove_if(first_windows_.begin(), first_windows_.end(), over), first_windows_.end());
}

void CoupledRun::warn(const std::string& text) {
  progress_.close();
  fmt::print(stderr, "warning: {}: {}\n", scene_.path, printable(text));
  summary_.notes.push_back(text);
}

/// A balance without somebody's columns would accuse whoever is right.
void CoupledRun::note_untold(const Untold& untold) {
  summary_.energy_not_told_by = untold.energy;
  summary_.momentum_not_told_by = untold.momentum;
  if (!untold.energy.empty())
    warn(fmt::format("energy is not told by {}: its drift is none, and the energy watch does not run",
                     fmt::join(untold.energy, ", ")));
  if (!untold.momentum.empty())
    warn(fmt::format("momentum is not told by {}: its error is none", fmt::join(untold.momentum, ", ")));
}

void CoupledRun::note_lost_momentum() {
  constexpr double rounding = 1e-6, much = 0.01;
  const bool exact = suspicion_.keeps_momentum;
  if (watch_->momentum_lost() <= (exact ? rounding : much)) return;
  std::string text = fmt::format("{:.3g} % of the momentum came from nowhere or got lost, protocol {} {}",
                                 100 * watch_->momentum_lost(), scene_.coupling.protocol.name,
                                 exact ? "keeps it to rounding" : does_not_keep_momentum);
  for (const auto& name : suspicion_.foreign) text += "; " + check_advice(name, scene_.path);
  warn(text);
}

void CoupledRun::prepare_watch(const std::vector<PeerDescription>& descriptions, const Untold& untold) {
  suspicion_.protocol = scene_.coupling.protocol.name;
  suspicion_.protocol_trouble = scene_.coupling.protocol.trouble;
  constexpr double tight_iteration = 1e-8;
  suspicion_.keeps_momentum = scene_.substeps().most <= scene_.coupling.protocol.exact_up_to_substeps &&
                              (!scene_.coupling.protocol.iterated || scene_.coupling.tolerance <= tight_iteration);
  suspicion_.step_s = problem_.clock.largest_size_s() / scene_.substeps().most;
  suspicion_.step_key = scene_.time.flight_step_s ? "time.flight_step_s" : "time.step_s";
  suspicion_.penalty_step_ratio = plan_.penalty_step_ratio;
  suspicion_.scene_path = scene_.path;
  suspicion_.links_told = untold.interface.empty();
  for (const auto& participant : scene_.participants) {
    if (participant.foreign()) suspicion_.foreign.push_back(participant.name);
  }
  std::vector<std::string> names;
  for (const auto& description : descriptions) {
    names.push_back(description.participant);
    if (description.role == Role::explicit_solver)
      suspicion_.steps.push_back({description.participant, description.critical_time_step_s});
  }
  const double growth = untold.energy.empty() ? scene_.coupling.energy_growth_limit : HUGE_VAL;
  watch_ =
      std::make_unique<EnergyWatch>(growth, energy_floor_j(problem_), suspicion_, names, scene_.body_names(),
                                    EnergyWatch::every_of(problem_.windows_of_scene), loss_limits(problem_, untold));
}

/// Only who enforces the contact knows when it is over, and it must be able to integrate a whole window explicitly.
bool CoupledRun::may_switch() {
  const auto* implicit = coupling_->implicit_link();
  const bool wanted = scene_.coupling.after_separation == scene::AfterSeparation::switch_to_explicit;
  if (!scene_.coupling.protocol.coupled() || !wanted || !implicit || !implicit->description().contact_owner)
    return false;
  const double critical = implicit->description().critical_time_step_s;
  std::string obstacle;
  if (!scene_.coupling.protocol.may_switch) {
    obstacle = fmt::format("protocol {} couples it implicitly only", scene_.coupling.protocol.name);
  } else if (!implicit->description().has(Capability::switch_integration)) {
    obstacle = "it lacks the capability \"switch_integration\"";
  } else if (!plan_.switch_obstacle.empty()) {
    obstacle = plan_.switch_obstacle;
  } else if (critical > 0 &&
             critical < problem_.clock.largest_size_s()) {  // of a solver that has elements we know nothing of
    obstacle = fmt::format("its critical time step {:.4g} s is below the step {:.4g} s", critical,
                           problem_.clock.largest_size_s());
  }
  if (obstacle.empty()) return true;
  summary_.notes.push_back(fmt::format("'{}' stays implicit after separation: {}", implicit->name(), obstacle));
  return false;
}

void CoupledRun::step() {
  loop_->run();
  if (checkpoints_ && scene_.checkpoint.asked) save(loop_->window());
  if (const std::string note = protocol_->note(); !note.empty()) summary_.notes.push_back(note);
}

void CoupledRun::take_records(std::int64_t window) {
  auto& links = coupling_->links();
  for (std::size_t p = 0; p < links.size(); ++p) {
    const auto records = links[p].take_records();
    if (comparisons_[p] && !records.empty()) {
      comparisons_[p]->check_first_row(records, links[p].driven_by_force() ? Drive::force : Drive::displacement);
      comparisons_[p].reset();
    }
    history_->add(p, records);
    if (axial_stress_) axial_stress_->add(p, links[p].take_axial_stress());
    if (probes_) probes_->add(p, links[p].take_probes());
  }
  note_departures(window);
  const auto valid_until_s = outside_.valid_until_s();
  if (probes_) write_probes(valid_until_s);
  for (auto& link : links) take_contact_forces(link.take_contact_forces(), valid_until_s);
  while (auto row = history_->next(problem_.clock)) {
    count_contact(*row);
    since_last_row_.contact_iterations += row->contact.contact_iterations;
    since_last_row_.contact_residual = std::max(since_last_row_.contact_residual, row->contact.contact_residual);
    const bool valid = !valid_until_s || row->time_s <= *valid_until_s;
    if (valid && !forces_told_) add_forces(*row);
    if (valid && row->window % scene_.output.history_every == 0) {
      row->contact.contact_iterations = std::exchange(since_last_row_.contact_iterations, 0.0);
      row->contact.contact_residual = std::exchange(since_last_row_.contact_residual, 0.0);
      history_file_.add(*row);
      tally_.add(*row);
      progress_.show(window, problem_.clock, *row);
    }
    watch_->check(*row);
  }
  outside_.stop_if_wrong();
}

/// Takes those of every window, whatever rows there are.
void CoupledRun::take_contact_forces(const std::vector<double>& rows, std::optional<double> valid_until_s) {
  const std::size_t width = 1 + std::max<std::size_t>(tally_.each_contact.size(), 1);
  forces_told_ = forces_told_ || !rows.empty();
  for (std::size_t row = 0; row + width <= rows.size(); row += width) {
    if (valid_until_s && problem_.clock.time_s(static_cast<std::int64_t>(rows[row])) > *valid_until_s) return;
    tally_.add_forces(static_cast<std::int64_t>(rows[row]), &rows[row + 1]);
  }
}

/// For an owner of the contact that does not tell every window's.
void CoupledRun::add_forces(const HistoryRow& row) {
  std::vector<double> forces;
  for (const auto& contact : row.contact.contacts) forces.push_back(contact.contact_force_n);
  if (forces.empty()) forces.push_back(row.contact.contact_force_n);
  tally_.add_forces(row.window, forces.data());
}

void CoupledRun::note_departures(std::int64_t window) {
  for (const auto& text : outside_.update(coupling_->links(), window)) {
    progress_.close();
    fmt::print(stderr, "warning: {}\n", printable(text));
  }
  summary_.outside_model = outside_.found();
  summary_.valid_until_s = outside_.valid_until_s();
}

/// A counter holds until its next event, so only changes are kept.
void CoupledRun::count_contact(const HistoryRow& row) {
  const ContactCounter now{row.window, row.contact.contact_iterations, row.contact.contact_residual};
  const ContactCounter last = contact_counters_.empty() ? ContactCounter{} : contact_counters_.back();
  if (now.iterations == last.iterations && now.residual == last.residual) return;
  if (contact_counters_.size() < Peers::max_spans) contact_counters_.push_back(now);
}

void CoupledRun::finish() {
  const auto last_words = coupling_->finish();
  take_records(loop_->window());
  note_lost_momentum();
  set_.check_exit_codes();
  take_times(last_words);
}

}  // namespace ricochet::coupler
