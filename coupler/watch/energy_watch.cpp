#include "coupler/watch/energy_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/base/process.hpp"
#include "common/problem/critical_step.hpp"

namespace ricochet::coupler {
namespace {

constexpr double smallest_strain = 1e-12;
/// Shares of the energy, where a program of somebody else's takes part, and of the momentum.
constexpr double energy_loss = 0.3, momentum_loss = 0.2;
/// Less momentum than this share of that of all mass with all energy is none to compare with.
constexpr double least_moving = 0.1;

double energy(const BodyTotals& body) { return body.energy_kinetic_j + body.energy_strain_j; }

bool finite(const HistoryRow& row) {
  const auto& c = row.contact;
  double sum = energy(row.sum) + row.sum.energy_external_j + row.sum.energy_interface_j + row.sum.momentum_n_kg_m_s +
               row.sum.momentum_t_kg_m_s + c.gap_min_m + c.contact_force_n + c.energy_contact_j + c.energy_friction_j;
  for (const auto& body : row.bodies) sum += energy(body);
  return std::isfinite(sum) && !std::isinf(row.energy_error) && !std::isinf(row.momentum_error);  // nan: not told
}

}  // namespace

std::string check_advice(const std::string& participant, const std::string& scene_path) {
  return fmt::format(
      "participant '{0}', a program of your own: `{1} check-participant --scene {2} --name {0}` compares it with ours",
      participant, command_name, scene_path);
}

std::string likely_cause(const Suspicion& suspicion, double interface_j, double growth_j) {
  std::vector<std::string> causes;
  for (const auto& step : suspicion.steps) {
    if (!(step.critical_time_step_s > 0)) continue;
    const double ratio = suspicion.step_s / step.critical_time_step_s;
    if (ratio > 0.999) {
      causes.push_back(
          fmt::format("the time step is {:.4g} times the critical step {:.4g} s of participant '{}'; lower {}", ratio,
                      step.critical_time_step_s, step.participant, suspicion.step_key));
    }
  }
  if (suspicion.penalty_step_ratio > 1.0) {
    causes.push_back(
        fmt::format("the contact penalty is too stiff for the step: sqrt(2 alpha/m) dt = {:.3g}, safe up to about 1; "
                    "lower contact.penalty_pa_m or use enforcement = \"multiplier\"",
                    suspicion.penalty_step_ratio));
  }
  for (const auto& name : suspicion.foreign) {
    causes.push_back(check_advice(name, suspicion.scene_path));
  }
  if (!suspicion.protocol_trouble.empty()) {
    causes.push_back(fmt::format("protocol {} {}", suspicion.protocol, suspicion.protocol_trouble));
  } else if (growth_j > 0 && interface_j > 0.5 * growth_j) {
    causes.push_back(fmt::format("protocol {}: its interface made most of that energy", suspicion.protocol));
  }
  if (causes.empty()) {
    causes.emplace_back(
        "not obvious from the scene (step, penalty and protocol look sound); try a shorter step, by time.step_s or, "
        "where "
        "the scene has none, time.safety_factor");
  }
  return fmt::format("likely cause: {}", fmt::join(causes, "; or "));
}

LossLimits loss_limits(const scene::Problem& problem, const Untold& untold) {
  const auto& scene = problem.scene;
  LossLimits limits;
  const bool foreign = std::any_of(scene.participants.begin(), scene.participants.end(),
                                   [](const scene::ParticipantSpec& participant) { return participant.foreign(); });
  if (untold.momentum.empty()) limits.momentum = momentum_loss;
  if (!untold.energy.empty()) return limits;
  if (foreign) limits.energy = energy_loss;
  if (scene.coupling.energy_loss_limit) limits.energy = *scene.coupling.energy_loss_limit;
  return limits;
}

double energy_floor_j(const scene::Problem& problem) {
  double sum = 0.0;
  for (const auto& body : problem.bodies) {
    sum += scene::body_lumped_mass(body).sum() * body.material.youngs_modulus_pa / body.material.density_kg_m3;
  }
  return smallest_strain * smallest_strain * sum;
}

EnergyWatch::EnergyWatch(double limit, double floor_j, Suspicion suspicion, std::vector<std::string> participants,
                         std::vector<std::string> bodies, std::int64_t look_every, LossLimits losses)
    : losses_(losses),
      limit_(limit),
      floor_j_(floor_j),
      every_(look_every),
      suspicion_(std::move(suspicion)),
      participants_(std::move(participants)),
      bodies_(std::move(bodies)) {}

void EnergyWatch::check(const HistoryRow& row) {
  if (!finite(row)) stop(row, "a result is not finite", 0.0);
  if (row.window % every_ != 0) return;
  const double growth_j = balance_.created_j(row), reference_j = std::max(balance_.reference_j(), floor_j_);
  if (counts(growth_j > limit_ * reference_j, row.window, growing_since_)) {
    stop(row,
         fmt::format("the energy balance has grown by {:.3g} % (coupling.energy_growth_limit = {:.3g} %)",
                     100 * growth_j / reference_j, 100 * limit_),
         growth_j);
  }
  check_losses(row, -growth_j, reference_j);
  last_energy_j_.clear();
  for (const auto& body : row.bodies) last_energy_j_.push_back(energy(body));
}

bool EnergyWatch::counts(bool beyond, std::int64_t window, std::optional<std::int64_t>& since) const {
  if (!beyond) since.reset();
  if (beyond && !since) since = window;
  return since && (balance_.mostly_initial() || window - *since >= patience);
}

void EnergyWatch::check_losses(const HistoryRow& row, double lost_j, double reference_j) {
  const auto stop_for = [&](const std::string& what, bool protocol_may) {
    const std::string cause =
        protocol_may ? fmt::format("likely cause: protocol {} {}", suspicion_.protocol, does_not_keep_momentum)
                     : likely_cause(suspicion_, 0.0, 0.0);
    throw EnergyGrowth(fmt::format("wrong in window {} (t = {:.6g} s): {}; {}", row.window, row.time_s, what, cause));
  };
  // Bodies that swing in themselves have no momentum but rounding.
  const double reference_kg_m_s =
      std::max(row.momentum_reference_kg_m_s, least_moving * std::sqrt(2.0 * row.sum.mass_kg * reference_j));
  const double lost_kg_m_s = row.momentum_error * row.momentum_reference_kg_m_s;
  if (reference_kg_m_s > 0.0) momentum_lost_ = std::max(momentum_lost_, lost_kg_m_s / reference_kg_m_s);
  if (counts(lost_kg_m_s > losses_.momentum * reference_kg_m_s, row.window, drifting_since_)) {
    stop_for(fmt::format("{:.3g} % of the momentum came from nowhere or got lost, allowed are {:.3g} %",
                         100 * lost_kg_m_s / reference_kg_m_s, 100 * losses_.momentum),
             !suspicion_.keeps_momentum && suspicion_.foreign.empty());
  }
  if (counts(lost_j > losses_.energy * reference_j, row.window, losing_since_)) {
    stop_for(fmt::format("{:.3g} % of the energy got lost (coupling.energy_loss_limit = {:.3g} %)",
                         100 * lost_j / reference_j, 100 * losses_.energy),
             false);
  }
}

void EnergyWatch::stop(const HistoryRow& row, const std::string& what, double growth_j) const {
  throw EnergyGrowth(fmt::format(
      "unstable in window {} (t = {:.6g} s): {}; {}; {}", row.window, row.time_s, what, culprit(row, growth_j),
      likely_cause(suspicion_, suspicion_.links_told ? row.sum.energy_interface_j : 0.0, growth_j)));
}

/// Where the energy was made: a participant's own balance tells, since loads and link are accounted for; the body only
/// tells where it shows.
std::string EnergyWatch::culprit(const HistoryRow& row, double growth_j) const {
  std::size_t body = 0;
  double largest = -1;
  for (std::size_t b = 0; b < row.bodies.size(); ++b) {
    const double before = b < last_energy_j_.size() ? last_energy_j_[b] : 0.0;
    const double grown = energy(row.bodies[b]) - before;
    if (!std::isfinite(grown) || grown > largest) {
      largest = std::isfinite(grown) ? grown : HUGE_VAL;
      body = b;
    }
  }
  std::string text = row.bodies.empty() ? "" : fmt::format("it grows most in body '{}'", bodies_[body]);
  if (!suspicion_.links_told) return text;
  const auto made = std::max_element(row.created_j.begin(), row.created_j.end(), [](double a, double b) {
    return (std::isnan(a) ? HUGE_VAL : a) < (std::isnan(b) ? HUGE_VAL : b);
  });
  if (made == row.created_j.end()) return text;
  const auto& participant = participants_[static_cast<std::size_t>(made - row.created_j.begin())];
  if (!std::isfinite(*made) || *made > row.sum.energy_interface_j) {
    return text + fmt::format(" and is made by participant '{}'", participant);
  }
  return text + (growth_j > 0 ? " and is made at the interface between the participants" : "");
}

}  // namespace ricochet::coupler
