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

TEST(Schema, AFieldOfSeveralKindsHasOneTypeAndUnit) {
  std::map<std::string_view, std::pair<std::size_t, std::string_view>> known;
  for (const Kind kind : all_kinds()) {
    Message message;
    message.kind = kind;
    for (const auto& field : fields_of(kind)) {
      const std::pair type_and_unit{field.in(message).index(), field.unit};
      const auto [found, added] = known.emplace(field.name, type_and_unit);
      EXPECT_EQ(found->second, type_and_unit) << name(kind) << "." << field.name;
    }
  }
}

TEST(Message, IsReadAsWhatItIs) {
  Message message;
  message.make<Advanced>().increment.resize(1, 1);
  EXPECT_EQ(message.as<Advanced>().increment.rows, 1);
  try {
    (void)message.as<Accepted>();
    FAIL();
  } catch (const std::logic_error& error) {
    EXPECT_STREQ(error.what(), "a message 'advanced' is read as 'accepted'");
  }
}

TEST(Message, MadeAnewHasTheFieldsOfANewOneAndKeepsItsMemory) {
  for (const Kind kind : all_kinds()) {
    Message message = sample(kind), fresh;
    clear_body(message);
    fresh.kind = kind;
    static_cast<Header&>(fresh) = message;
    expect_same(message, fresh);
  }
  Message message = sample(Kind::advanced);
  message.as<Advanced>().increment.resize(50, 2);
  const auto* numbers = message.as<Advanced>().increment.data.data();
  EXPECT_TRUE(message.make<Advanced>().increment.data.empty());
  message.make<Accepted>();
  auto& again = message.make<Advanced>();
  again.increment.resize(50, 2);
  EXPECT_EQ(again.increment.data.data(), numbers);
  EXPECT_EQ(again.separation_time_s, -1.0);
}

}  // namespace
}  // namespace ricochet::wire
