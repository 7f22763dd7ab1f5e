#include <gtest/gtest.h>

#include "common/base/sha256.hpp"

namespace ricochet {
namespace {

// FIPS 180-4 examples.
TEST(Sha256, KnownDigests) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256, ZeroBytesCount) {
  EXPECT_NE(sha256_hex(std::string_view("a\0b", 3)), sha256_hex(std::string_view("a", 1)));
}

TEST(Sha256, OfPiecesIsThatOfTheWhole) {
  Sha256 digest;
  EXPECT_EQ(digest.hex(), sha256_hex(""));
  digest.add("a");
  EXPECT_EQ(digest.hex(), sha256_hex("a"));
  Sha256 other = digest;
  digest.add("bc");
  EXPECT_EQ(digest.hex(), sha256_hex("abc"));
  other.add(std::string(1000, 'x'));
  EXPECT_EQ(other.hex(), sha256_hex("a" + std::string(1000, 'x')));
}

// RFC 4231, cases 1, 2 and 6.
TEST(Sha256, OfAKeyAsTheStandardHasIt) {
  EXPECT_EQ(hmac_sha256_hex(std::string(20, '\x0b'), "Hi There"),
            "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(hmac_sha256_hex("Jefe", "what do ya want for nothing?"),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(hmac_sha256_hex(std::string(131, '\xaa'), "Test Using Larger Than Block-Size Key - Hash Key First"),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

}  // namespace
}  // namespace ricochet
