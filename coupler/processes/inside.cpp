#include "coupler/processes/inside.hpp"

#include <utility>

namespace ricochet::coupler {
namespace {

MakeInside& maker() {
  static MakeInside make;
  return make;
}

}  // namespace

void let_inside(MakeInside make) { maker() = std::move(make); }

const MakeInside& make_inside() { return maker(); }

Inside::Inside(std::unique_ptr<participant::Participant> participant)
    : participant_(std::move(participant)), session_(*participant_) {
  wire::Message hello;
  session_.hello(hello);
}

void Inside::take(wire::Message& request) {
  std::swap(request_, request);
  asked_ = true;
}

bool Inside::work(wire::Message& answer) {
  bool answers = false;
  try {
    if (std::exchange(due_, false)) session_.work_ahead();
    if (asked_) {
      asked_ = false;
      session_.add_wait(std::chrono::duration<double>(wire::Clock::now() - idle_since_).count());
      answers = session_.handle(request_, answer);
      due_ = !session_.over();
      idle_since_ = wire::Clock::now();
    }
  } catch (...) {
    const auto reason = participant::reason_in(session_);
    if (session_.over()) return false;
    session_.failure(reason.code, reason.text, answer);
    answers = true;
  }
  return answers;
}

}  // namespace ricochet::coupler
