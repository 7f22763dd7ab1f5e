#include "common/participant/participant.hpp"

#include "common/base/archive.hpp"
#include "common/base/error.hpp"

namespace ricochet::participant {

void ContactStatus::archive(Archive& a) {
  a(pairs_closed, gap_min_m, gap_rate_min_m_s, separated, separation_time_s, finished);
}

void Departure::archive(Archive& a) {
  a(kind, body, last_without, first, looks, largest, window, x_m, y_m, z_m, first_size, first_x_m, first_y_m,
    first_z_m);
}

void Participant::load_state(const std::vector<double>&, FrozenContact) {
  throw ParticipantError("it announces the capability 'load_state' but cannot load a state");
}

void Participant::read_state(std::vector<double>&, std::vector<double>&) {
  throw ParticipantError("it announces the capability 'load_state' but cannot tell its state");
}

std::string Participant::save_state() {
  throw ParticipantError("it announces the capability 'save_state' but cannot save its state");
}

void Participant::restore_state(std::string_view) {
  throw ParticipantError("it announces the capability 'save_state' but cannot restore a state");
}

}  // namespace ricochet::participant
