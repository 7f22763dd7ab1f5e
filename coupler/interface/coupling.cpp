#include "coupler/interface/coupling.hpp"

#include <algorithm>
#include <cmath>

#include "coupler/interface/vectors.hpp"

namespace ricochet::coupler {

Coupling::Coupling(std::vector<Peer> peers, const std::vector<PeerDescription>& descriptions, WindowClock clock)
    : map_(descriptions), clock_(std::move(clock)) {
  for (std::size_t p = 0; p < peers.size(); ++p)
    links_.emplace_back(std::move(peers[p]), descriptions[p], map_.rows(p));
  const std::size_t size = static_cast<std::size_t>(map_.nodes()) * map_.components();
  for (auto* vector : {&displacement_, &velocity_, &acceleration_, &prediction_, &force_}) vector->assign(size, 0.0);
  const auto found = std::find_if(links_.begin(), links_.end(), [](const Link& link) { return link.implicit(); });
  if (found != links_.end()) implicit_ = &*found;
}

void Coupling::initialize(const wire::Initialize& request) {
  for (auto& link : links_) link.post_initialize(request, masses_of(link, Masses::summed));
  for (auto& link : links_) link.wait_initialized();
  if (implicit_) implicit_->rows().scatter(implicit_->output(), displacement_);
  synchronise(Integration::implicit_newmark);
}

std::vector<double> Coupling::masses_of(const Link& link, Masses masses) const {
  if (masses == Masses::own) return link.description().interface_mass_kg.data;
  return link.rows().per_node(map_.mass_kg());
}

std::vector<double> Coupling::summed_mass_kg(const Link& link) const {
  std::vector<double> masses;
  for (const double mass : link.rows().per_node(map_.mass_kg())) masses.insert(masses.end(), map_.components(), mass);
  return masses;
}

void Coupling::initialize_explicit(const wire::Initialize& request, Masses masses) {
  for (auto& link : links_) {
    if (!link.implicit()) link.post_initialize(request, masses_of(link, masses));
  }
  for (auto& link : links_) {
    if (!link.implicit()) link.wait_initialized();
  }
}

void Coupling::initialize_implicit(wire::Initialize request, Masses masses, Eigen::MatrixXd interface_stiffness) {
  if (!implicit_) return;
  interface_stiffness_ = std::move(interface_stiffness);
  if (interface_stiffness_.size() > 0) {
    const Eigen::MatrixXd own = own_stiffness();
    request.interface_stiffness.resize(static_cast<int>(own.rows()), static_cast<int>(own.cols()));
    std::copy_n(own.data(), own.size(), request.interface_stiffness.data.begin());
  }
  implicit_->post_initialize(request, masses_of(*implicit_, masses));
  implicit_->wait_initialized();
  implicit_->rows().scatter(implicit_->output(), displacement_);
}

/// In the rows of the implicit participant.
Eigen::MatrixXd Coupling::own_stiffness() const {
  if (interface_stiffness_.size() == 0) return {};
  const auto dofs = implicit_->rows().dofs();
  return interface_stiffness_(dofs, dofs);
}

void Coupling::reconfigure() {
  reconfigure_explicit();
  reconfigure_implicit(interface_stiffness_);
}

void Coupling::reconfigure_explicit() {
  reconfigured_ = true;
  for (auto& link : links_) {
    if (!link.implicit()) link.post_reconfigure(window_size_s(), {});
  }
  for (auto& link : links_) {
    if (!link.implicit()) link.wait_reconfigured();
  }
}

void Coupling::reconfigure_implicit(Eigen::MatrixXd interface_stiffness) {
  if (!implicit_) return;
  interface_stiffness_ = std::move(interface_stiffness);
  implicit_->post_reconfigure(window_size_s(), own_stiffness());
  implicit_->wait_reconfigured();
}

std::vector<wire::Finished> Coupling::finish() {
  for (auto& link : links_) link.post_finish();
  std::vector<wire::Finished> last_words;
  for (auto& link : links_) last_words.push_back(link.wait_finished());
  return last_words;
}

const std::vector<double>& Coupling::rows_of(const Link& link, const std::vector<double>& shared) {
  if (link.rows().all_in_order(static_cast<std::size_t>(map_.nodes()))) return shared;
  link.rows().gather(shared, own_);
  return own_;
}

void Coupling::synchronise(Integration integration) {
  for (auto& link : links_) {
    if (!link.implicit()) link.post_synchronise(Integration::explicit_central, rows_of(link, displacement_));
  }
  std::fill(force_.begin(), force_.end(), 0.0);
  for (auto& link : links_) {
    if (link.implicit()) continue;
    link.wait_synchronised();
    link.rows().add(link.output(), force_);
  }
  all_explicit_ = integration == Integration::explicit_central;
  if (implicit_) synchronise_implicit(force_, integration);
}

void Coupling::synchronise_implicit(std::vector<double> force, Integration integration) {
  if (integration == Integration::implicit_newmark) subtract_stiffness_force(force);
  implicit_->post_synchronise(integration, rows_of(*implicit_, force));
  implicit_->wait_synchronised();
  take_motion();
}

const std::vector<double>& Coupling::predicted(double beta) {
  const double dt = window_size_s();
  const double factor = (0.5 - beta) * dt * dt;
  for (std::size_t i = 0; i < displacement_.size(); ++i) {
    prediction_[i] = displacement_[i] + dt * velocity_[i] + factor * acceleration_[i];
  }
  return prediction_;
}

const std::vector<double>& Coupling::advance_explicit(const Step& step, const std::vector<double>& displacement,
                                                      Acceptance acceptance) {
  for (auto& link : links_) {
    if (!link.implicit()) link.post_advance(step, rows_of(link, displacement), acceptance);
  }
  std::fill(force_.begin(), force_.end(), 0.0);
  for (auto& link : links_) {
    if (link.implicit()) continue;
    link.wait_advanced();
    link.rows().add(link.output(), force_);
  }
  return force_;
}

void Coupling::advance_implicit(const Step& step, const std::vector<double>& force, Acceptance acceptance) {
  implicit_->post_advance(step, rows_of(*implicit_, force), acceptance);
  implicit_->wait_advanced();
  take_motion();
}

void Coupling::subtract_stiffness_force(std::vector<double>& force) const {
  if (interface_stiffness_.size() == 0) return;
  Eigen::Map<Eigen::VectorXd>(force.data(), interface_stiffness_.rows()).noalias() -=
      interface_stiffness_ * view(displacement_);
}

void Coupling::accept(const Step& step) {
  for (auto& link : links_) link.post_accept(step);
  for (auto& link : links_) link.wait_accepted();
}

void Coupling::advance_alone(const Step& step) {
  for (auto& link : links_) link.post_advance(step, rows_of(link, displacement_), Acceptance::at_once);
  for (auto& link : links_) link.wait_advanced();
}

void Coupling::take_motion() {
  const auto& rows = implicit_->rows();
  rows.scatter(implicit_->output(), displacement_);
  if (map_.nodes() == 0) return;
  rows.scatter(implicit_->velocity_m_s(), velocity_);
  rows.scatter(implicit_->acceleration_m_s2(), acceleration_);
}

void Coupling::load_state(const std::vector<double>& state, FrozenContact frozen_contact) {
  auto from = state.begin();
  const auto take = [&from](std::size_t size) {
    from += static_cast<std::ptrdiff_t>(size);
    return std::vector<double>(from - static_cast<std::ptrdiff_t>(size), from);
  };
  for (std::size_t p = 0; p < links_.size(); ++p) links_[p].post_load_state(take(state_sizes_[p]), frozen_contact);
  for (auto& link : links_) link.wait_state_loaded();
  for (auto& link : links_) {
    link.post_synchronise(link.implicit() ? Integration::implicit_newmark : Integration::explicit_central,
                          take(link.input().size()));
  }
  for (auto& link : links_) link.wait_synchronised();
  if (implicit_) take_motion();
}

void Coupling::read_state(std::vector<double>& state, std::vector<double>& scale) {
  state.clear();
  scale.clear();
  state_sizes_.clear();
  for (auto& link : links_) link.post_read_state();
  for (auto& link : links_) {
    const auto& answer = link.wait_state();
    state.insert(state.end(), answer.state.data.begin(), answer.state.data.end());
    scale.insert(scale.end(), answer.state_scale.data.begin(), answer.state_scale.data.end());
    state_sizes_.push_back(answer.state.data.size());
  }
  for (const auto& link : links_) {
    state.insert(state.end(), link.input().begin(), link.input().end());
    for (const double mass_kg : link.rows().per_node(map_.mass_kg())) {
      const double root = std::sqrt(mass_kg);
      const double of_input =
          link.driven_by_force() ? window_size_s() / root : root / window_size_s();  // force, displacement
      scale.insert(scale.end(), static_cast<std::size_t>(link.rows().components()), of_input);
    }
  }
}

std::vector<std::string> Coupling::save_states() {
  for (auto& link : links_) link.post_save_state();
  std::vector<std::string> saved;
  for (auto& link : links_) saved.push_back(link.wait_saved_state());
  return saved;
}

void Coupling::restore_states(const std::vector<std::string>& saved) {
  for (std::size_t p = 0; p < links_.size(); ++p) links_[p].post_restore_state(saved[p]);
  for (auto& link : links_) link.wait_state_restored();
}

void Coupling::archive(Archive& a) {
  const auto size = displacement_.size();
  for (auto& link : links_) a(link);
  a(displacement_, velocity_, acceleration_, all_explicit_, interface_drift_m_);
  a(reconfigured_);
  if (reconfigured_) archive_matrix(a, interface_stiffness_);  // else what the start makes
  if (displacement_.size() != size || velocity_.size() != size || acceleration_.size() != size)
    a.refuse("another interface");
}

const Link* Coupling::implicit_link() const { return implicit_; }
Link* Coupling::implicit_link() { return implicit_; }

const wire::ContactReport& Coupling::contact() const {
  static const wire::ContactReport none;
  for (const auto& link : links_) {
    if (link.description().contact_owner) return link.contact();
  }
  return none;
}

std::int64_t Coupling::window() const {
  const auto behind = [](const Link& a, const Link& b) { return a.window() < b.window(); };
  return std::min_element(links_.begin(), links_.end(), behind)->window();
}

void Coupling::note_interface_drift() {
  for (const auto& link : links_) {
    if (link.implicit() || !link.driven_by_force()) continue;
    const auto& own = rows_of(link, displacement_);
    for (std::size_t i = 0; i < own.size(); ++i)
      interface_drift_m_ = std::max(interface_drift_m_, std::abs(own[i] - link.output()[i]));
  }
}

double Coupling::largest_drift() const {
  double largest = 0.0;
  for (const auto& link : links_) largest = std::max(largest, link.largest_drift());
  return largest;
}

}  // namespace ricochet::coupler
