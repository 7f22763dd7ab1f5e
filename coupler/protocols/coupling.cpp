#include "coupler/protocols/coupling.hpp"

#include <algorithm>

namespace ricochet::coupler {

Coupling::Coupling(std::vector<Link> links, InterfaceMap map, double window_size_s)
    : links_(std::move(links)), map_(std::move(map)), window_size_s_(window_size_s) {
  const std::size_t size = static_cast<std::size_t>(map_.nodes()) * map_.components();
  for (auto* vector : {&displacement_, &velocity_, &acceleration_, &prediction_, &force_}) vector->assign(size, 0.0);
  const auto found = std::find_if(links_.begin(), links_.end(), [](const Link& link) { return link.implicit(); });
  if (found != links_.end()) implicit_ = &*found;
}

void Coupling::initialize(const wire::Message& request) {
  for (auto& link : links_) link.post_initialize(request, map_.mass_kg());
  for (auto& link : links_) link.wait_initialized();
  if (implicit_) implicit_->rows().scatter(implicit_->output(), displacement_);
  synchronise("implicit_newmark");
}

void Coupling::synchronise(const std::string& integration) {
  for (auto& link : links_) {
    if (!link.implicit()) link.post_synchronise("explicit_central", displacement_);
  }
  std::fill(force_.begin(), force_.end(), 0.0);
  for (auto& link : links_) {
    if (link.implicit()) continue;
    link.wait_synchronised();
    link.rows().add(link.output(), force_);
  }
  all_explicit_ = integration == "explicit_central";
  if (!implicit_) return;
  implicit_->post_synchronise(integration, force_);
  implicit_->wait_synchronised();
  take_motion();
}

const std::vector<double>& Coupling::predicted(double beta) {
  const double dt = window_size_s_;
  const double factor = (0.5 - beta) * dt * dt;
  for (std::size_t i = 0; i < displacement_.size(); ++i) {
    prediction_[i] = displacement_[i] + dt * velocity_[i] + factor * acceleration_[i];
  }
  return prediction_;
}

const std::vector<double>& Coupling::advance_explicit(const Step& step, const std::vector<double>& displacement,
                                                      Acceptance acceptance) {
  for (auto& link : links_) {
    if (!link.implicit()) link.post_advance(step, displacement, acceptance);
  }
  std::fill(force_.begin(), force_.end(), 0.0);
  for (auto& link : links_) {
    if (link.implicit()) continue;
    link.wait_advanced();
    link.rows().add(link.output(), force_);
  }
  return force_;
}

void Coupling::advance_implicit(const Step& step, const std::vector<double>& force) {
  implicit_->post_advance(step, force, Acceptance::at_once);
  implicit_->wait_advanced();
  take_motion();
}

void Coupling::advance_alone(const Step& step) {
  for (auto& link : links_) link.post_advance(step, displacement_, Acceptance::at_once);
  for (auto& link : links_) link.wait_advanced();
}

void Coupling::take_motion() {
  const auto& rows = implicit_->rows();
  rows.scatter(implicit_->output(), displacement_);
  if (map_.nodes() == 0) return;
  rows.scatter(implicit_->velocity_m_s(), velocity_);
  rows.scatter(implicit_->acceleration_m_s2(), acceleration_);
}

const Link* Coupling::implicit_link() const { return implicit_; }

const ContactReport& Coupling::contact() const {
  static const ContactReport none;
  for (const auto& link : links_) {
    if (link.description().contact_owner) return link.contact();
  }
  return none;
}

std::int64_t Coupling::window() const {
  const auto behind = [](const Link& a, const Link& b) { return a.window() < b.window(); };
  return std::min_element(links_.begin(), links_.end(), behind)->window();
}

double Coupling::largest_drift() const {
  double largest = 0.0;
  for (const auto& link : links_) largest = std::max(largest, link.largest_drift());
  return largest;
}

}  // namespace ricochet::coupler
