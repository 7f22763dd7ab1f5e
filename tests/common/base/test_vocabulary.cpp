#include <gtest/gtest.h>

#include "common/base/vocabulary.hpp"

namespace ricochet {
namespace {

template <class E>
class Vocabulary : public testing::Test {};
using Enums = testing::Types<Role, Integration, Drive, FrozenContact, Transport, Capability, RunStatus>;
TYPED_TEST_SUITE(Vocabulary, Enums);

TYPED_TEST(Vocabulary, EveryValueHasItsPlaceAndANameOfItsOwn) {
  const auto& table = NamesOf<TypeParam>::table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(table[i].value), i) << table[i].name;
    EXPECT_EQ(find_named<TypeParam>(name_of(table[i].value)), table[i].value);
  }
  EXPECT_EQ(name_of(static_cast<TypeParam>(table.size())), "");
  EXPECT_EQ(find_named<TypeParam>(""), std::nullopt);
}

}  // namespace
}  // namespace ricochet
