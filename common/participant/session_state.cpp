// The state that a session and its participant go on from.
#include <fmt/format.h>

#include <algorithm>

#include "common/base/archive.hpp"
#include "common/participant/session.hpp"

namespace ricochet::participant {

/// The state that this end of the link goes on from, beside the participant.
void Session::archive(Archive& a) {
  a(accepted_window_, fields_window_);
  a.same_size(link_);
  a(contact_, rows_, stress_rows_, probe_rows_, force_rows_, force_columns_);
  const auto whole = [](const std::vector<double>& rows, std::size_t columns) {
    return columns == 0 ? rows.empty() : rows.size() % columns == 0;
  };
  if (accepted_window_ < 0 || accepted_window_ > setup_.last_window ||
      !whole(rows_, description_.record_columns.size()) ||
      !whole(stress_rows_, description_.axial_stress_columns.size()) ||
      !whole(probe_rows_, description_.probe_columns.size()) || force_columns_ < -1 ||
      !whole(force_rows_, static_cast<std::size_t>(1 + std::max<std::int64_t>(force_columns_, 0))))
    a.refuse("it is of another run");
  window_ = accepted_window_;
  const WindowClock before = setup_.clock;
  a(setup_.clock);
  if (setup_.clock.changes()) a.same_size(setup_.interface_stiffness);
  if (setup_.clock == before) return;
  if (!can(Capability::reconfigure)) a.refuse("it is of windows whose size changed");
  participant_.reconfigure(setup_);
}

void Session::save_state(wire::SavedState& reply) {
  if (!can(Capability::save_state))
    throw ProtocolError(
        fmt::format("the coupler asked to save the state, but participant '{}' lacks the capability 'save_state'",
                    description_.name));
  Archive out;
  std::string own = participant_.save_state();
  archive(out);
  out(own);
  reply.saved.data = out.take();
}

void Session::restore_state(const wire::RestoreState& request) {
  if (!can(Capability::save_state))
    throw ProtocolError(
        fmt::format("the coupler asked to restore a state, but participant '{}' lacks the capability 'save_state'",
                    description_.name));
  Archive in(request.saved.data, fmt::format("the state of participant '{}'", description_.name));
  std::string own;
  archive(in);
  in(own);
  in.end();
  participant_.restore_state(own);
}

}  // namespace ricochet::participant
