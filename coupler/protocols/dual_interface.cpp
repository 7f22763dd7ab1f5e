#include "coupler/protocols/dual_interface.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>

#include "common/base/error.hpp"
#include "coupler/interface/vectors.hpp"
#include "coupler/protocols/unit_response.hpp"

namespace ricochet::coupler {
namespace {

/// Below this share of the largest response a degree of freedom is held by a support.
constexpr double held_share = 1e-10;

/// Inverse on the degrees of freedom that respond, zero on the others.
Eigen::MatrixXd inverse_where_free(const Eigen::MatrixXd& h, const std::string& participant) {
  std::vector<Eigen::Index> free;
  const double largest = h.size() > 0 ? h.diagonal().maxCoeff() : 0.0;
  for (Eigen::Index i = 0; i < h.rows(); ++i) {
    if (h(i, i) > held_share * largest) free.push_back(i);
  }
  const Eigen::MatrixXd responding = h(free, free);
  const Eigen::LLT<Eigen::MatrixXd> factor(responding);
  if (factor.info() != Eigen::Success) {
    throw ConfigError(fmt::format(
        "participant '{}': its interface operator is not positive definite, so no multiplier can keep the velocities "
        "equal; use a smaller step or fewer substeps",
        participant));
  }
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(responding.rows(), responding.cols());
  const Eigen::MatrixXd solved = factor.solve(identity);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(h.rows(), h.cols());
  inverse(free, free) = solved;
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace

void DualInterface::start(Coupling& coupling, const wire::Initialize& request, const Step& probe) {
  wire::Initialize by_force = request;
  by_force.driven_by = name_of(Drive::force);
  coupling.initialize_explicit(by_force, Masses::own);
  const auto size = static_cast<Eigen::Index>(coupling.displacement().size());
  impedance_.setZero(size, size);
  held_.setZero(size);
  force_.assign(static_cast<std::size_t>(size), 0.0);
  substeps_ = static_cast<int>(request.substeps);
  for (auto& link : coupling.links()) {
    if (link.implicit()) continue;
    sides_.push_back({&link, {}, {}, {}, {}, {}, {}, {}});
    auto& side = sides_.back();
    link.post_synchronise(Integration::explicit_central, std::vector<double>(link.input().size(), 0.0));
    link.wait_synchronised();
    side.acceleration = link.acceleration_m_s2();
    measure(side, probe, step_s(coupling, probe));
  }
  coupling.initialize_implicit(by_force, Masses::own, stiffness(coupling));
  start_multipliers(coupling);
}

/// Duration of a probe.
double DualInterface::step_s(const Coupling& coupling, const Step& probe) const {
  return coupling.window_size_s() / (probe.substep == 0 ? 1.0 : static_cast<double>(substeps_));
}

/// S = 2/dt Z.
Eigen::MatrixXd DualInterface::stiffness(const Coupling& coupling) const {
  return (2.0 / coupling.window_size_s()) * impedance_;
}

void DualInterface::reconfigure(Coupling& coupling, const Step& probe) {
  coupling.reconfigure_explicit();
  impedance_.setZero();
  for (auto& side : sides_) measure(side, probe, step_s(coupling, probe));
  coupling.reconfigure_implicit(stiffness(coupling));
  reconfigured_ = true;
}

void DualInterface::archive(Archive& a) {
  a(reconfigured_);
  if (!reconfigured_) return;
  archive_matrix(a, impedance_);
  for (auto& side : sides_) archive_matrix(a, side.impedance);
}

void DualInterface::measure(Side& side, const Step& probe, double step_s) {
  auto& link = *side.link;
  std::vector<double> probes = link.own_mass_kg();
  for (std::size_t i = 0; i < probes.size(); ++i) {
    if (!(probes[i] > 0)) {
      throw ConfigError(
          fmt::format("participant '{}' has no mass at interface node {}: a dual protocol needs own elements "
                      "on either side",
                      link.name(), i / static_cast<std::size_t>(link.rows().components())));
    }
    probes[i] /= step_s;  // about 1 m/s each
  }
  side.impedance = inverse_where_free(unit_response(link, Response::velocity, probe, probes), link.name());
  link.rows().add_matrix(side.impedance, impedance_);
}

/// lambda_p = m_p (a - a_p), with a_p the acceleration of a participant alone and a the mass-weighted mean of all.
void DualInterface::start_multipliers(Coupling& coupling) {
  auto& implicit = *coupling.implicit_link();
  coupling.synchronise_implicit(to_vector(multiplier()));
  std::vector<double> mass(force_.size(), 0.0), force = mass;
  const auto add = [&](const Link& link, const std::vector<double>& acceleration) {
    const auto own_mass = link.own_mass_kg();
    link.rows().add(own_mass, mass);
    link.rows().add(to_vector(view(own_mass).cwiseProduct(view(acceleration))), force);
  };
  add(implicit, implicit.acceleration_m_s2());
  for (const auto& side : sides_) add(*side.link, side.acceleration);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] /= mass[i];
  std::vector<double> common;
  for (auto& side : sides_) {
    std::vector<double> multiplier = side.link->own_mass_kg();
    side.link->rows().gather(force, common);
    for (std::size_t i = 0; i < multiplier.size(); ++i) multiplier[i] *= common[i] - side.acceleration[i];
    side.link->post_synchronise(Integration::explicit_central, multiplier);
    side.link->wait_synchronised();
  }
  coupling.synchronise_implicit(to_vector(multiplier()));
}

Eigen::VectorXd DualInterface::multiplier() const {
  std::vector<double> sum(static_cast<std::size_t>(held_.size()), 0.0);
  for (const auto& side : sides_) side.link->rows().add(side.link->input(), sum);
  return view(sum);
}

void DualInterface::advance_free(const Step& step) {
  Step trial = step;
  trial.absolute = trial.records = false;
  for (auto& side : sides_) side.link->post_advance(trial, side.link->input(), Acceptance::trial);
  std::fill(force_.begin(), force_.end(), 0.0);
  for (auto& side : sides_) {
    side.link->wait_advanced();
    side.free_velocity = view(side.link->velocity_m_s());
    side.force.noalias() = side.impedance * side.free_velocity;
    side.multiplier = side.link->input();
    for (std::size_t i = 0; i < side.multiplier.size(); ++i)
      side.multiplier[i] -= side.force[static_cast<Eigen::Index>(i)];
    side.link->rows().add(side.multiplier, force_);
  }
  held_ = view(force_);
}

const std::vector<double>& DualInterface::held_force(const Coupling& coupling) {
  Eigen::Map<Eigen::VectorXd> force(force_.data(), held_.size());
  force.noalias() = impedance_ * view(coupling.velocity());
  force = held_ - force;
  coupling.subtract_stiffness_force(force_);
  return force_;
}

void DualInterface::correct(const Step& step, const std::vector<double>& velocity) {
  for (auto& side : sides_) {
    side.link->rows().gather(velocity, side.common);
    side.jump = view(side.common) - side.free_velocity;
    side.force.noalias() = side.impedance * side.jump;
    side.multiplier = side.link->input();
    for (std::size_t i = 0; i < side.multiplier.size(); ++i)
      side.multiplier[i] += side.force[static_cast<Eigen::Index>(i)];
    side.link->post_advance(step, side.multiplier, Acceptance::at_once);
  }
  for (auto& side : sides_) side.link->wait_advanced();
}

}  // namespace ricochet::coupler
