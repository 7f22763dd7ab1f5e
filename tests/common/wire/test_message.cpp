#include <gtest/gtest.h>

#include <set>

#include "tests/common/wire/samples.hpp"

namespace ricochet::wire {
namespace {

TEST(Schema, KindsStandInTheOrderOfTheEnumeration) {
  ASSERT_EQ(all_kinds().size(), static_cast<std::size_t>(Kind::failure) + 1);
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < all_kinds().size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(all_kinds()[i]), i);
    EXPECT_TRUE(names.insert(name(all_kinds()[i])).second);
  }
}

TEST(Schema, FieldNamesAreUniqueInAMessageAndTellTheirUnit) {
  for (const Kind kind : all_kinds()) {
    std::set<std::string_view> names;
    for (const auto* fields : {&header_fields(), &fields_of(kind)}) {
      for (const auto& field : *fields) {
        EXPECT_TRUE(names.insert(field.name).second) << name(kind) << "." << field.name;
        EXPECT_FALSE(field.meaning.empty()) << name(kind) << "." << field.name;
        const bool seconds = field.name.ends_with("_s") && !field.name.ends_with("_m_s");
        EXPECT_EQ(seconds, field.unit == "s") << name(kind) << "." << field.name;
      }
    }
    EXPECT_LE(names.size(), 64U) << "the decoder marks what it has seen in 64 bits";
  }
}

TEST(Schema, AFieldOfSeveralKindsIsTheSameMember) {
  std::map<std::string_view, Field> known;
  for (const Kind kind : all_kinds()) {
    for (const auto& field : fields_of(kind)) {
      const auto [found, added] = known.emplace(field.name, field);
      EXPECT_TRUE(found->second.member == field.member) << name(kind) << "." << field.name;
    }
  }
}

TEST(Clear, LeavesANewMessageButKeepsTheMemory) {
  for (const Kind kind : all_kinds()) {
    Message message = sample(kind);
    message.increment.resize(50, 2);
    message.error_text.assign(500, 'x');
    const auto* numbers = message.increment.data.data();
    const auto* text = message.error_text.data();
    clear(message);
    expect_same(message, Message{});
    message.increment.resize(50, 2);
    message.error_text.assign(500, 'x');
    EXPECT_EQ(message.increment.data.data(), numbers);
    EXPECT_EQ(message.error_text.data(), text);
  }
}

}  // namespace
}  // namespace ricochet::wire
