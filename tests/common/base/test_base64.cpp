#include <gtest/gtest.h>

#include "common/base/base64.hpp"

namespace ricochet {
namespace {

// RFC 4648, section 10.
TEST(Base64, KnownTexts) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64(std::string_view("\xff\x00\xfe", 3)), "/wD+");
}

TEST(Base64, IsReadBack) {
  std::string bytes;
  for (int i = 0; i < 256; ++i) {
    EXPECT_EQ(from_base64(base64(bytes)), bytes) << i;
    bytes += static_cast<char>(i);
  }
}

TEST(Base64, WhatIsNoneIsNotRead) {
  for (const char* text : {"Zg=", "Z", "Zm9v!mFy", "Zg=v", "====", "Zm 9"}) EXPECT_FALSE(from_base64(text)) << text;
}

}  // namespace
}  // namespace ricochet
