#include "common/wire/lifecycle.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace ricochet::wire {
namespace {

struct StateText {
  State state;
  std::string_view name, phrase;
};

/// In the order of `State`.
constexpr StateText state_texts[] = {
    {State::connecting, "connecting", "'hello' was due"},
    {State::greeting, "greeting", "'hello' was unanswered"},
    {State::welcomed, "welcomed", "'describe' was due"},
    {State::describing, "describing", "'describe' was outstanding"},
    {State::described, "described", "'initialize' was due"},
    {State::initializing, "initializing", "'initialize' was outstanding"},
    {State::initialized, "initialized", "'synchronise' was due"},
    {State::synchronising, "synchronising", "'synchronise' was outstanding"},
    {State::ready, "ready", "the next window was due"},
    {State::advancing, "advancing", "'advance' was outstanding"},
    {State::trying, "trying", "'advance' (a trial) was outstanding"},
    {State::tried, "tried", "a trial waited to be accepted or repeated"},
    {State::accepting, "accepting", "'accept' was outstanding"},
    {State::loading, "loading", "'load_state' was outstanding"},
    {State::reading, "reading", "'read_state' was outstanding"},
    {State::finishing, "finishing", "'finish' was outstanding"},
    {State::finished, "finished", "the run was finished"},
    {State::failed, "failed", "the run had failed"},
};

bool fits(const Transition& row, State state, Side sender, const Message& message) {
  if (row.state != state || row.sender != sender || row.kind != message.kind) return false;
  return row.acceptance == Acceptance::any || (row.acceptance == Acceptance::at_once) == message.accept_at_once;
}

std::string who(Side sender, std::string_view participant) {
  return sender == Side::participant ? fmt::format("participant '{}'", participant) : "the coupler";
}

/// "expected one of 'a', 'b'", by what the table allows.
std::string expected(State state, Side sender) {
  if (state == State::finished || state == State::failed) return "expected nothing more";
  std::vector<std::string> kinds;
  for (const auto& row : transitions()) {
    std::string quoted = fmt::format("'{}'", name(row.kind));
    const bool known = !kinds.empty() && kinds.back() == quoted;  // the two kinds of advance stand together
    if (row.state == state && row.sender == sender && !known) kinds.push_back(std::move(quoted));
  }
  if (kinds.empty()) return "it was not its turn";
  kinds.push_back(fmt::format("'{}'", name(Kind::failure)));
  return fmt::format("expected one of {}", fmt::join(kinds, ", "));
}

}  // namespace

std::string_view name(State state) { return state_texts[static_cast<std::size_t>(state)].name; }

std::string_view phrase(State state) { return state_texts[static_cast<std::size_t>(state)].phrase; }

const std::vector<State>& all_states() {
  static const std::vector<State> states = [] {
    std::vector<State> all;
    for (const auto& text : state_texts) all.push_back(text.state);
    return all;
  }();
  return states;
}

const std::vector<Transition>& transitions() {
  using enum State;
  constexpr auto coupler = Side::coupler, participant = Side::participant;
  static const std::vector<Transition> table{
      {connecting, participant, Kind::hello, greeting},
      {greeting, coupler, Kind::welcome, welcomed},
      {welcomed, coupler, Kind::describe, describing},
      {describing, participant, Kind::description, described},
      {described, coupler, Kind::initialize, initializing},
      {initializing, participant, Kind::initialized, initialized},
      {initialized, coupler, Kind::synchronise, synchronising},
      {synchronising, participant, Kind::synchronised, ready},
      {ready, coupler, Kind::advance, advancing, Acceptance::at_once},
      {ready, coupler, Kind::advance, trying, Acceptance::on_request},
      {ready, coupler, Kind::synchronise, synchronising},
      {ready, coupler, Kind::load_state, loading},
      {ready, coupler, Kind::read_state, reading},
      {ready, coupler, Kind::finish, finishing},
      {advancing, participant, Kind::advanced, ready},
      {trying, participant, Kind::advanced, tried},
      {tried, coupler, Kind::advance, advancing, Acceptance::at_once},
      {tried, coupler, Kind::advance, trying, Acceptance::on_request},
      {tried, coupler, Kind::accept, accepting},
      {tried, coupler, Kind::synchronise, synchronising},
      {accepting, participant, Kind::accepted, ready},
      {loading, participant, Kind::state_loaded, initialized},
      {reading, participant, Kind::state, ready},
      {finishing, participant, Kind::finished, finished},
  };
  return table;
}

void Lifecycle::step(Side sender, const Message& message, std::string_view participant) {
  if (message.kind == Kind::failure && !done()) {
    state_ = State::failed;
    return;
  }
  for (const auto& row : transitions()) {
    if (!fits(row, state_, sender, message)) continue;
    auto& next = next_sequence_[static_cast<std::size_t>(sender)];
    if (message.sequence != next) {
      throw ProtocolError(
          fmt::format("{} sent '{}' as message number {}, expected number {}: one was lost or sent twice",
                      who(sender, participant), name(message.kind), message.sequence, next));
    }
    ++next;
    state_ = row.next;
    return;
  }
  const auto addressee = sender == Side::coupler ? fmt::format(" to participant '{}'", participant) : "";
  throw ProtocolError(fmt::format("{} sent '{}'{} while {}; {}", who(sender, participant), name(message.kind),
                                  addressee, phrase(state_), expected(state_, sender)));
}

}  // namespace ricochet::wire
