// The part of CoupledRun that writes down what a run was: times, summary, trace, index of the fields.
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/base/write_file.hpp"
#include "coupler/results/obstacles_file.hpp"
#include "coupler/run/coupled_run.hpp"

namespace ricochet::coupler {

double CoupledRun::cpu_time_s() {
  double sum = 0.0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const auto& time : {usage.ru_utime, usage.ru_stime}) {
      sum += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }
  }
  return sum;
}

double CoupledRun::wall_s() const {
  return (from_ ? from_->wall_s : 0.0) + std::chrono::duration<double>(Clock::now() - begin_).count();
}

double CoupledRun::cpu_spent_s() const { return (from_ ? from_->cpu_s : 0.0) + cpu_time_s() - begin_cpu_s_; }

double CoupledRun::stepping_s() const {
  return (from_ ? from_->stepping_s : 0.0) + std::chrono::duration<double>(Clock::now() - stepping_).count();
}

void CoupledRun::fail(RunStatus status, int exit_code, const std::string& error) {
  progress_.close();
  // A participant that has computed windows writes what the report's picture is drawn from.
  set_.fail(exit_code, error, std::chrono::milliseconds(loop_ ? 1000 : 0));
  summary_.status = status;
  summary_.exit_code = exit_code;
  summary_.error = error;
  if (summary_.processes.empty()) take_times({});
  try {
    write_files();
  } catch (const std::exception& second) {
    fmt::print(stderr, "{}: {}\n", command_name, printable(text_of(second)));  // the first error is the one to report
  }
}

/// `last_words`: the participants' `finished` messages; empty if the run did not come that far.
void CoupledRun::take_times(const std::vector<wire::Finished>& last_words) {
  const double wall_s = std::chrono::duration<double>(Clock::now() - begin_).count();
  const auto& peers = set_.peers();
  ProcessTimes coupler{"coupler", {}, static_cast<std::int64_t>(getpid()), {}, wall_s, 0.0, 0.0, {}};
  for (std::size_t p = 0; p < peers.size(); ++p) {
    coupler.waited_for.push_back({peers.name(p), peers.waited_for_s(p)});
    *coupler.wait_s += peers.waited_for_s(p);
    tracks_.push_back({"coupler", "waits for " + peers.name(p), peers.wait_spans(p), {}});
    if (coupling_ && coupling_->links()[p].description().contact_owner) tracks_.back().counters = contact_counters_;
  }
  coupler.compute_s = wall_s - *coupler.wait_s;
  summary_.processes.push_back(coupler);
  for (std::size_t p = 0; p < peers.size(); ++p) {
    ProcessTimes process{
        peers.name(p), scene_.participants[p].role, peers.process_id(p), peers.transport(p), wall_s, {}, {}, {}};
    process.inside = peers.inside(p);
    for (std::size_t q = 0; q < peers.size(); ++q) {
      if (q != p) process.waited_for.push_back({peers.name(q), peers.idle_while_s(p, q)});
    }
    if (!last_words.empty()) {
      const auto& words = last_words[p];
      process.compute_s = words.compute_s;
      process.wait_s = words.wait_s;
      double for_others = 0.0;
      for (const auto& entry : process.waited_for) for_others += entry.time_s;
      process.waited_for.push_back({"coupler", std::max(0.0, words.wait_s - for_others)});
      auto& track = tracks_.emplace_back(TraceTrack{peers.name(p), "computes", {}, {}});
      for (int i = 0; i < words.spans_s.rows && words.spans_s.columns == 3; ++i) {
        const double* span = &words.spans_s.data[3 * static_cast<std::size_t>(i)];
        if (!(span[0] >= 0.0 && span[0] <= static_cast<double>(plan_.windows))) continue;  // no window of this run
        track.spans.push_back({static_cast<std::int64_t>(span[0]), span[1], span[2]});
      }
    }
    summary_.processes.push_back(process);
  }
}

void CoupledRun::prepare_probes(const std::vector<PeerDescription>& descriptions) {
  if (!scene_.output.wants_probes()) return;
  std::vector<History::Source> sources;
  for (const auto& description : descriptions) sources.push_back({description.participant, description.probe_columns});
  probes_ = std::make_unique<Probes>(sources, scene_);
  std::vector<std::string> columns = probes_->columns();
  columns.insert(columns.begin(), "time_s");
  probe_file_ = std::make_unique<RowFile>(results_.file("probes.csv"), columns, from_ ? from_->probes : Beginning{});
  note_untold_probes(descriptions);
}

void CoupledRun::note_untold_probes(const std::vector<PeerDescription>& descriptions) {
  const auto untold = probes_->untold();
  if (untold.empty()) return;
  std::vector<std::string> bodies, silent;
  const auto add_body = [&](const auto& place) {
    if (std::find(untold.begin(), untold.end(), place.name) != untold.end()) bodies.push_back(place.body);
  };
  for (const auto& probe : scene_.output.probes) add_body(probe);
  for (const auto& gauge : scene_.output.gauges) add_body(gauge);
  for (const auto& description : descriptions) {
    const auto& of = scene_.participant(description.participant).bodies;
    const bool has_it = description.role == Role::implicit_solver ||
                        std::find_first_of(of.begin(), of.end(), bodies.begin(), bodies.end()) != of.end();
    if (has_it && description.probe_columns.empty()) silent.push_back(description.participant);
  }
  warn(fmt::format("{} in probes.csv is nan where shares are missing: {} tells of no probe and no gauge",
                   fmt::join(untold, ", "), fmt::join(silent, ", ")));
}

void CoupledRun::write_probes(std::optional<double> valid_until_s) {
  while (const auto row = probes_->next(problem_.clock)) {
    if (valid_until_s && row->time_s > *valid_until_s) continue;
    if (row->window % scene_.output.probes_every != 0) continue;
    probe_file_->put(row->time_s);
    for (const double value : row->values) probe_file_->put(value);
    probe_file_->end_row();
  }
}

/// Each file, whatever happens to the others; then throws what went wrong first.
void CoupledRun::write_files() {
  progress_.close();
  summary_.wall_s = wall_s();
  summary_.cpu_s = cpu_spent_s();
  if (loop_) {
    summary_.windows = loop_->window();
    summary_.clock = problem_.clock;
    summary_.switches = loop_->switches();
  }
  if (coupling_) {
    summary_.largest_drift = coupling_->largest_drift();
    summary_.interface_drift_m = coupling_->interface_drift_m();
  }
  std::exception_ptr first;
  const auto attempt = [&first](const auto& write) {
    try {
      write();
    } catch (const std::exception&) {
      if (!first) first = std::current_exception();
    }
  };
  attempt([this] { history_file_.flush(); });
  if (probe_file_) attempt([this] { probe_file_->flush(); });
  attempt([this] { write_fields_and_trace(); });
  attempt([this] { write_summary(); });
  if (first) std::rethrow_exception(first);
}

void CoupledRun::write_fields_and_trace() {
  const auto names = participant_names(scene_);
  std::vector<std::string> bodies;
  for (const auto& body : scene_.bodies) bodies.push_back(body.name);
  write_collection(results_, std::filesystem::path(scene_.path).stem().string(), bodies, names, problem_.clock);
  if (const auto obstacles = obstacles_text(problem_); !obstacles.empty())
    write_atomically(results_.file("fields/obstacles.json"), obstacles);
  const double begin_s = std::chrono::duration<double>(begin_.time_since_epoch()).count();
  write_atomically(results_.file("trace.json"), to_trace(tracks_, begin_s));
  if (axial_stress_ && axial_stress_->told())
    write_atomically(results_.file("axial_stress.csv"), axial_stress_->csv(problem_.clock));
  for (const auto& warning : {contact_warning(tally_), substeps_warning(summary_, tally_)}) {
    if (!warning.empty()) fmt::print(stderr, "warning: {}: {}\n", printable(scene_.path), warning);
  }
}

/// How the run ended is written down on a full disk, too: in the place that `reserve_summary` took.
void CoupledRun::write_summary() {
  const auto path = results_.file("summary.json");
  try {
    write_atomically(path, to_json(summary_, tally_));
  } catch (const MachineError&) {
    if (!write_within(path, to_json(summary_, tally_))) throw;
  }
}

void CoupledRun::reserve_summary() const {
  constexpr std::size_t room = 1 << 15;
  std::string text = to_json(summary_, tally_);
  text.resize(std::max(room, text.size()), ' ');
  write_atomically(results_.file("summary.json"), text);
}

}  // namespace ricochet::coupler
