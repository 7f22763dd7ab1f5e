#include <gmock/gmock.h>

#include "common/base/error.hpp"
#include "coupler/interface/window_rows.hpp"

namespace ricochet::coupler {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

wire::Array rows(const std::vector<double>& values, int columns) {
  wire::Array array;
  array.set(values, static_cast<int>(values.size()) / columns, columns);
  return array;
}

class Rows : public testing::Test {
 protected:
  WindowRows rows_{"axial_stress", "axial stress row", 2};
  std::string error(const wire::Array& array, std::int64_t computed, std::int64_t requested) {
    try {
      rows_.take(array, "spring", computed, requested);
    } catch (const ProtocolError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(Rows, ComeOnceAndInOrder) {
  rows_.expect_every(5);
  rows_.take(rows({0, 1.5, 5, 2.5}, 2), "spring", 7, 7);
  rows_.take({}, "spring", 9, 9);
  EXPECT_THAT(rows_.taken(), ElementsAre(0, 1.5, 5, 2.5));
  EXPECT_THAT(error(rows({5, 1}, 2), 12, 12),
              HasSubstr("sent in 'axial_stress' the axial stress row of window 5, the next one is that of window 10"));
  EXPECT_THAT(error(rows({15, 1}, 2), 12, 12), HasSubstr("of window 15"));
}

TEST_F(Rows, AreNotLeftOutWhenTheyWereAskedFor) {
  rows_.expect_every(5);
  EXPECT_EQ(error({}, 3, -1), "no error");
  EXPECT_THAT(error({}, 3, 3), HasSubstr("left out of 'axial_stress' the axial stress row of window 0"));
}

TEST_F(Rows, HaveTheColumnsThatWereAnnounced) {
  rows_.expect_every(1);
  EXPECT_THAT(error(rows({0, 1, 2}, 3), 0, 0), HasSubstr("rows of 3 numbers, it announced 2 columns"));
}

TEST_F(Rows, ThatNobodyWantsAreRefused) {
  rows_.expect_every(0);
  EXPECT_EQ(error({}, 3, 3), "no error");
  EXPECT_THAT(error(rows({0, 1}, 2), 3, 3), HasSubstr("sent 1 rows in 'axial_stress', expected none"));
}

}  // namespace
}  // namespace ricochet::coupler
