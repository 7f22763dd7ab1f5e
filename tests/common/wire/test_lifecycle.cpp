#include <fmt/format.h>
#include <gmock/gmock.h>

#include <deque>
#include <map>
#include <set>

#include "common/base/error.hpp"
#include "common/wire/lifecycle.hpp"

namespace ricochet::wire {
namespace {

using testing::HasSubstr;

/// One thing that can be said.
struct Said {
  Side sender;
  Kind kind;
  bool accept_at_once;
};

std::vector<Said> everything() {
  std::vector<Said> all;
  for (const Side sender : {Side::coupler, Side::participant}) {
    for (const Kind kind : all_kinds()) {
      for (const bool at_once : {false, true}) all.push_back({sender, kind, at_once});
    }
  }
  return all;
}

/// A conversation, with the sequence numbers that belong to it.
class Conversation {
 public:
  void say(const Said& said) {
    auto& sequence = sequence_[static_cast<std::size_t>(said.sender)];
    Message message;
    message.kind = said.kind;
    if (said.kind == Kind::advance) message.as<Advance>().accept_at_once = said.accept_at_once;
    message.sequence = sequence;
    lifecycle.step(said.sender, message, "rod");
    ++sequence;
  }
  Lifecycle lifecycle;

 private:
  std::int64_t sequence_[2] = {0, 0};
};

bool legal(const Transition& row, const Said& said) {
  return row.sender == said.sender && row.kind == said.kind &&
         (row.form == AdvanceForm::any || (row.form == AdvanceForm::at_once) == said.accept_at_once);
}

/// The shortest conversation that leads to each state.
std::map<LifecycleState, std::vector<Said>> paths() {
  std::map<LifecycleState, std::vector<Said>> found{{LifecycleState::connecting, {}}};
  std::deque<LifecycleState> next{LifecycleState::connecting};
  while (!next.empty()) {
    const LifecycleState state = next.front();
    next.pop_front();
    for (const auto& row : transitions()) {
      if (row.state != state || found.contains(row.next)) continue;
      found[row.next] = found[state];
      found[row.next].push_back({row.sender, row.kind, row.form == AdvanceForm::at_once});
      next.push_back(row.next);
    }
  }
  found[LifecycleState::failed] = {{Side::coupler, Kind::failure, false}};
  return found;
}

/// A conversation that has come to `state`.
Conversation conversation_at(LifecycleState state) {
  Conversation conversation;
  const auto path = paths().at(state);
  for (const auto& said : path) conversation.say(said);
  return conversation;
}

class EveryState : public testing::TestWithParam<LifecycleState> {
 protected:
  [[nodiscard]] Conversation there() const { return conversation_at(GetParam()); }
  [[nodiscard]] bool over() const {
    return GetParam() == LifecycleState::finished || GetParam() == LifecycleState::failed;
  }
};

TEST_P(EveryState, IsReachedAndNamed) {
  EXPECT_EQ(there().lifecycle.state(), phrase(GetParam()));
  EXPECT_EQ(there().lifecycle.done(), over());
}

TEST_P(EveryState, LetsThroughWhatTheTableHasAndRefusesAllElse) {
  for (const auto& said : everything()) {
    const auto row = std::find_if(transitions().begin(), transitions().end(),
                                  [&](const auto& r) { return r.state == GetParam() && legal(r, said); });
    auto conversation = there();
    if (row != transitions().end()) {
      EXPECT_NO_THROW(conversation.say(said)) << name(said.kind);
      EXPECT_EQ(conversation.lifecycle.state(), phrase(row->next));
    } else if (said.kind == Kind::failure && !over()) {
      conversation.say(said);
      EXPECT_TRUE(conversation.lifecycle.done());
    } else {
      try {
        conversation.say(said);
        ADD_FAILURE() << name(said.kind) << " was let through in " << name(GetParam());
      } catch (const ProtocolError& error) {
        const std::string sender = said.sender == Side::coupler ? "the coupler" : "participant 'rod'";
        EXPECT_THAT(error.what(), testing::StartsWith(fmt::format("{} sent '{}'", sender, name(said.kind))));
        EXPECT_THAT(error.what(), HasSubstr(fmt::format("while {};", phrase(GetParam()))));
        EXPECT_EQ(conversation.lifecycle.state(), phrase(GetParam()));
      }
    }
  }
}

TEST_P(EveryState, NamesWhatWouldBeLegal) {
  for (const Side sender : {Side::coupler, Side::participant}) {
    auto conversation = there();
    std::string text;
    try {
      conversation.say({sender, GetParam() == LifecycleState::connecting ? Kind::finished : Kind::hello, false});
    } catch (const ProtocolError& error) {
      text = error.what();
    }
    for (const auto& row : transitions()) {
      if (row.state == GetParam() && row.sender == sender && row.kind != Kind::progress) {  // which is no answer
        EXPECT_THAT(text, HasSubstr(fmt::format("'{}'", name(row.kind))));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lifecycle, EveryState, testing::ValuesIn(all_states()),
                         [](const auto& param_info) { return std::string(name(param_info.param)); });

TEST(Lifecycle, EveryStateIsReachable) { EXPECT_EQ(paths().size(), all_states().size()); }

TEST(Lifecycle, EveryKindIsInTheTable) {
  std::set<Kind> kinds{Kind::failure};
  for (const auto& row : transitions()) kinds.insert(row.kind);
  EXPECT_EQ(kinds.size(), all_kinds().size());
}

TEST(Lifecycle, SaysWhoDidWhatAndWhatWasExpected) {
  auto conversation = conversation_at(LifecycleState::initializing);
  try {
    conversation.say({Side::participant, Kind::advanced, false});
    FAIL();
  } catch (const ProtocolError& error) {
    EXPECT_STREQ(error.what(),
                 "participant 'rod' sent 'advanced' while 'initialize' was outstanding; expected one of 'initialized', "
                 "'failure'");
  }
  try {
    conversation.say({Side::coupler, Kind::advance, false});
    FAIL();
  } catch (const ProtocolError& error) {
    EXPECT_STREQ(
        error.what(),
        "the coupler sent 'advance' to participant 'rod' while 'initialize' was outstanding; it was not its turn");
  }
}

TEST(Lifecycle, NoticesALostAndARepeatedMessage) {
  for (const std::int64_t wrong : {-1, 0, 2, 100}) {
    auto conversation = conversation_at(LifecycleState::described);
    Message message;
    message.kind = Kind::initialize;
    message.sequence = wrong;  // welcome, describe came before: 2 is right
    if (wrong == 2) {
      EXPECT_NO_THROW(conversation.lifecycle.step(Side::coupler, message, "rod"));
      continue;
    }
    try {
      conversation.lifecycle.step(Side::coupler, message, "rod");
      FAIL();
    } catch (const ProtocolError& error) {
      EXPECT_EQ(error.what(),
                fmt::format("the coupler sent 'initialize' as message number {}, expected number 2: one was lost "
                            "or sent twice",
                            wrong));
    }
  }
}

TEST(Lifecycle, HearsAFailureWhateverItsNumber) {
  Lifecycle lifecycle;
  Message message;
  message.sequence = 17;
  lifecycle.step(Side::coupler, message, "rod");
  EXPECT_TRUE(lifecycle.done());
}

}  // namespace
}  // namespace ricochet::wire
