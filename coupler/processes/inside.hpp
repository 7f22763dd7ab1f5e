#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/participant/session.hpp"
#include "common/problem/problem.hpp"
#include "common/wire/channel.hpp"
#include "coupler/results/trace.hpp"

namespace ricochet::coupler {

/// A participant in the coupler's own process and thread: where processors are fewer than processes, a window has two
/// hand-overs less. The messages are the same as between processes, and so are the results, to the last bit. It
/// computes when the coupler has nothing else to do: before it waits for another participant, or for this one's answer.
class Inside {
 public:
  /// Asks it for its description: Session.
  explicit Inside(std::unique_ptr<participant::Participant> participant);

  /// See Session.
  void on_progress(participant::TellProgress tell) { session_.on_progress(std::move(tell)); }
  /// Takes what it is to do next; swapped with what it was asked before.
  void take(wire::Message& request);
  /// Does what it was asked, and is still to be done; true if `answer` then holds an answer. Throws nothing: what goes
  /// wrong is in the answer, a `failure`, as if the participant had sent it.
  bool work(wire::Message& answer);

 private:
  std::unique_ptr<participant::Participant> participant_;
  participant::Session session_;
  wire::Message request_;
  bool asked_ = false, due_ = false;  ///< a request; what the answer did not have to wait for
  wire::Clock::time_point idle_since_ = wire::Clock::now();
};

/// How the shipped solver of a participant, explicit or implicit, is made in this process; `critical_step_s`: what it
/// is told of its elements, see participant::Arguments.
using MakeInside = std::function<std::unique_ptr<participant::Participant>(
    const scene::Problem&, const std::string& name, std::optional<double> critical_step_s)>;
/// Told once by the program, which has the solvers: the rooms of the coupler know none. Without it every participant is
/// a process.
void let_inside(MakeInside make);
[[nodiscard]] const MakeInside& make_inside();

}  // namespace ricochet::coupler
