#pragma once

#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::fuzz {

/// Keeps the promises of a participant and computes next to nothing. Its kind depends on the bits of a byte.
class SmallParticipant : public participant::Participant {
 public:
  explicit SmallParticipant(unsigned bits) : bits_(bits), nodes_(bits & 3U) {}

  participant::Description describe() override {
    participant::Description d;
    d.name = "small";
    d.role = bit(2) ? participant::Role::implicit_solver : participant::Role::explicit_solver;
    d.components = bit(3) ? 2 : 1;
    d.bodies = {"rod"};
    d.interface_body.assign(nodes_, 0);
    d.interface_position_m.assign(size(), 0.5);
    d.interface_mass_kg.assign(nodes_, 2.0);
    if (bit(4)) d.axial_stress_columns = {"rod/0/1/1"};
    if (bit(4)) d.probe_columns = {"p.strain/1"};
    d.contact_owner = bit(5);
    d.record_columns = {"displacement_m"};
    for (const auto& [capability, name] : NamesOf<participant::Capability>::table)
      if (!bit(6)) d.capabilities.push_back(capability);
    return d;
  }
  void initialize(const participant::Setup& setup, participant::LinkOutput& output) override {
    forced_ = setup.driven_by == participant::Drive::force;
    put(output);
  }
  void synchronise(participant::Integration, const std::vector<double>& link,
                   participant::LinkOutput& output) override {
    take(link, output);
  }
  void advance(std::int64_t, const std::vector<double>& link, participant::LinkOutput& output) override {
    // A coupler may ask for any number of windows at once: here as many as are worth the time.
    if (++windows_ > 200) throw SolverError("enough windows for one input");
    take(link, output);
  }
  void advance_substep(std::int64_t window, int, const std::vector<double>& link,
                       participant::LinkOutput& output) override {
    advance(window, link, output);
  }
  void accept() override { moved_ = trial_; }
  [[nodiscard]] participant::ContactStatus contact_status() const override { return {1, moved_, 0.0}; }
  void record(std::vector<double>& row) override { row.push_back(moved_); }
  void axial_stress(std::vector<double>& row) override {
    if (bit(4)) row.push_back(moved_);
  }
  void probes(std::vector<double>& row) override {
    if (bit(4)) row.push_back(moved_);
  }
  std::vector<participant::Departure> departures() override { return {{}}; }
  std::vector<participant::OutlineNode> outline() override {
    return {{0, 1, std::vector<double>(bit(3) ? 2 : 1, moved_)}};
  }
  void load_state(const std::vector<double>& state, participant::FrozenContact) override { moved_ = state.at(0); }
  void read_state(std::vector<double>& state, std::vector<double>& scale) override {
    state = {moved_};
    scale = {1.0};
  }
  std::string save_state() override {
    Archive out;
    out(moved_, trial_);
    return out.take();
  }
  void restore_state(std::string_view bytes) override {
    Archive in(bytes, "the state");
    in(moved_, trial_);
    in.end();
  }

 private:
  [[nodiscard]] bool bit(unsigned n) const { return (bits_ >> n & 1U) != 0; }
  [[nodiscard]] std::size_t size() const { return nodes_ * (bit(3) ? 2 : 1); }
  void take(const std::vector<double>& link, participant::LinkOutput& output) {
    trial_ = moved_;
    for (const double value : link) trial_ += 0.5 * value;
    put(output);
  }
  void put(participant::LinkOutput& output) const {
    output.value.assign(size(), trial_);
    output.velocity_m_s.assign(forced_ ? size() : 0, trial_);
    output.acceleration_m_s2 = output.velocity_m_s;
  }

  unsigned bits_;
  std::size_t nodes_;
  bool forced_ = false;
  int windows_ = 0;
  double moved_ = 0.0, trial_ = 0.0;
};

}  // namespace ricochet::fuzz
