#include "common/wire/lifecycle.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace ricochet::wire {
namespace {

struct StateText {
  LifecycleState state;
  std::string_view name, phrase;
};

/// In the order of `LifecycleState`.
constexpr StateText state_texts[] = {
    {LifecycleState::connecting, "connecting", "'hello' was due"},
    {LifecycleState::greeting, "greeting", "'hello' was unanswered"},
    {LifecycleState::welcomed, "welcomed", "'describe' was due"},
    {LifecycleState::describing, "describing", "'describe' was outstanding"},
    {LifecycleState::described, "described", "'initialize' was due"},
    {LifecycleState::initializing, "initializing", "'initialize' was outstanding"},
    {LifecycleState::initialized, "initialized", "'synchronise' was due"},
    {LifecycleState::synchronising, "synchronising", "'synchronise' was outstanding"},
    {LifecycleState::reconfiguring, "reconfiguring", "'reconfigure' was outstanding"},
    {LifecycleState::ready, "ready", "the next window was due"},
    {LifecycleState::advancing, "advancing", "'advance' was outstanding"},
    {LifecycleState::trying, "trying", "'advance' (a trial) was outstanding"},
    {LifecycleState::tried, "tried", "a trial waited to be accepted or repeated"},
    {LifecycleState::accepting, "accepting", "'accept' was outstanding"},
    {LifecycleState::loading, "loading", "'load_state' was outstanding"},
    {LifecycleState::reading, "reading", "'read_state' was outstanding"},
    {LifecycleState::saving, "saving", "'save_state' was outstanding"},
    {LifecycleState::restoring, "restoring", "'restore_state' was outstanding"},
    {LifecycleState::finishing, "finishing", "'finish' was outstanding"},
    {LifecycleState::finished, "finished", "the run was finished"},
    {LifecycleState::failed, "failed", "the run had failed"},
};

bool fits(const Transition& row, LifecycleState state, Side sender, const Message& message) {
  if (row.state != state || row.sender != sender || row.kind != message.kind) return false;
  return row.form == AdvanceForm::any || (row.form == AdvanceForm::at_once) == message.as<Advance>().accept_at_once;
}

std::string who(Side sender, std::string_view participant) {
  return sender == Side::participant ? fmt::format("participant '{}'", participant) : "the coupler";
}

/// "expected one of 'a', 'b'", by what the table allows.
std::string expected(LifecycleState state, Side sender) {
  if (state == LifecycleState::finished || state == LifecycleState::failed) return "expected nothing more";
  std::vector<std::string> kinds;
  for (const auto& row : transitions()) {
    std::string quoted = fmt::format("'{}'", name(row.kind));
    const bool known = !kinds.empty() && kinds.back() == quoted;  // the two kinds of advance stand together
    if (row.state == state && row.sender == sender && !known && row.kind != Kind::progress)
      kinds.push_back(std::move(quoted));
  }
  if (kinds.empty()) return "it was not its turn";
  kinds.push_back(fmt::format("'{}'", name(Kind::failure)));
  return fmt::format("expected one of {}", fmt::join(kinds, ", "));
}

}  // namespace

std::string_view name(LifecycleState state) { return state_texts[static_cast<std::size_t>(state)].name; }

std::string_view phrase(LifecycleState state) { return state_texts[static_cast<std::size_t>(state)].phrase; }

const std::vector<LifecycleState>& all_states() {
  static const std::vector<LifecycleState> states = [] {
    std::vector<LifecycleState> all;
    for (const auto& text : state_texts) all.push_back(text.state);
    return all;
  }();
  return states;
}

const std::vector<Transition>& transitions() {
  using enum LifecycleState;
  constexpr auto coupler = Side::coupler, participant = Side::participant;
  static const std::vector<Transition> table{
      {connecting, participant, Kind::hello, greeting},
      {greeting, coupler, Kind::welcome, welcomed},
      {welcomed, coupler, Kind::describe, describing},
      {describing, participant, Kind::description, described},
      {described, coupler, Kind::initialize, initializing},
      {initializing, participant, Kind::progress, initializing},
      {initializing, participant, Kind::initialized, initialized},
      {initialized, coupler, Kind::synchronise, synchronising},
      {synchronising, participant, Kind::synchronised, ready},
      {ready, coupler, Kind::advance, advancing, AdvanceForm::at_once},
      {ready, coupler, Kind::advance, trying, AdvanceForm::on_request},
      {ready, coupler, Kind::synchronise, synchronising},
      {ready, coupler, Kind::reconfigure, reconfiguring},
      {ready, coupler, Kind::load_state, loading},
      {ready, coupler, Kind::read_state, reading},
      {ready, coupler, Kind::save_state, saving},
      {ready, coupler, Kind::restore_state, restoring},
      {ready, coupler, Kind::finish, finishing},
      {reconfiguring, participant, Kind::reconfigured, ready},
      {advancing, participant, Kind::advanced, ready},
      {trying, participant, Kind::advanced, tried},
      {tried, coupler, Kind::advance, advancing, AdvanceForm::at_once},
      {tried, coupler, Kind::advance, trying, AdvanceForm::on_request},
      {tried, coupler, Kind::accept, accepting},
      {tried, coupler, Kind::synchronise, synchronising},
      {accepting, participant, Kind::accepted, ready},
      {loading, participant, Kind::state_loaded, initialized},
      {reading, participant, Kind::state, ready},
      {saving, participant, Kind::saved_state, ready},
      {restoring, participant, Kind::state_restored, ready},
      {finishing, participant, Kind::finished, finished},
  };
  return table;
}

void Lifecycle::step(Side sender, const Message& message, std::string_view participant) {
  if (message.kind == Kind::failure && !done()) {
    state_ = LifecycleState::failed;
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
