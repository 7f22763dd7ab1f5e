#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/wire/message.hpp"

namespace ricochet::wire {

enum class Side { coupler, participant };

enum class LifecycleState {
  connecting,
  greeting,
  welcomed,
  describing,
  described,
  initializing,
  initialized,
  synchronising,
  reconfiguring,
  ready,
  advancing,
  trying,
  tried,
  accepting,
  loading,
  reading,
  saving,
  restoring,
  finishing,
  finished,
  failed,
};

/// A state in one word, and in a phrase that goes on after "while".
[[nodiscard]] std::string_view name(LifecycleState state);
[[nodiscard]] std::string_view phrase(LifecycleState state);
[[nodiscard]] const std::vector<LifecycleState>& all_states();

/// Which `advance` a row of the table is about.
enum class AdvanceForm { any, at_once, on_request };

struct Transition {
  LifecycleState state;
  Side sender;
  Kind kind;
  LifecycleState next;
  AdvanceForm form = AdvanceForm::any;
};

/// Everything that may be said, in the order of a run. Besides, either side may send `failure` in every state but
/// `finished` and `failed`; it leads to `failed`.
[[nodiscard]] const std::vector<Transition>& transitions();

/// Legal order of messages on one coupler-participant link, as one table used by both ends.
/// Also checks that sequence numbers of each direction count up by one (not of `failure`: it is heard in any case).
class Lifecycle {
 public:
  /// Call before sending and after receiving. `participant` is the name of the one on this link. Throws ProtocolError
  /// "participant 'x' sent 'advanced' while 'initialize' was outstanding; expected one of ...", the state stays.
  void step(Side sender, const Message& message, std::string_view participant);
  /// Where the conversation stands, as a phrase: "'initialize' was outstanding".
  [[nodiscard]] std::string_view state() const { return phrase(state_); }
  /// Finished or failed: no message is legal any more.
  [[nodiscard]] bool done() const { return state_ == LifecycleState::finished || state_ == LifecycleState::failed; }

 private:
  LifecycleState state_ = LifecycleState::connecting;
  std::int64_t next_sequence_[2] = {0, 0};
};

}  // namespace ricochet::wire
