#include <gtest/gtest.h>

#include <algorithm>

#include "common/base/parallel.hpp"
#include "tests/support/blocks.hpp"

namespace ricochet::solver {
namespace {

TEST(Threads, AreAParticipantsShareOfTheProcessorsUnlessTheSceneSays) {
  test::Blocks blocks("all_implicit");
  auto& participants = blocks.problem.scene.participants;
  auto participant = participants.front();
  const auto threads = [&] { return initial_states(blocks.problem, participant, true).front().parallel->threads(); };
  EXPECT_EQ(threads(), usable_processors());
  participants.push_back(participant);
  EXPECT_EQ(threads(), std::max(1, usable_processors() / 2));
  participants.insert(participants.end(), 2 * static_cast<std::size_t>(usable_processors()), participant);
  EXPECT_EQ(threads(), 1);
  participant.threads = 5;
  EXPECT_EQ(threads(), 5);
}

}  // namespace
}  // namespace ricochet::solver
