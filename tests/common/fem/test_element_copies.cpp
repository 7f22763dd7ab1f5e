#include <gtest/gtest.h>

#include "common/fem/element_copies.hpp"

namespace ricochet::fem {
namespace {

ElementGeometry line(double from_m, double to_m) {
  ElementGeometry geometry{ElementKind::bar, ElementCoordinates::Zero(2, 2)};
  geometry.x(0, 0) = from_m;
  geometry.x(1, 0) = to_m;
  return geometry;
}

// For a mesh without copies a value of every element would take several times the memory of K.
TEST(ElementCopies, AreMadeOnceAndOfAMeshWithoutThemAnewAtAskingAgain) {
  ElementCopies<double> copies(Model::bar);
  int made = 0;
  const auto length = [&](const ElementGeometry& geometry) {
    ++made;
    return geometry.x(1, 0) - geometry.x(0, 0);
  };
  for (int time = 0; time < 3; ++time) EXPECT_EQ(copies.of(line(0.0, 0.5), length), 0.5);
  EXPECT_EQ(made, 1);
  constexpr int many = 10000;
  for (int i = 1; i <= many; ++i) EXPECT_EQ(copies.of(line(i, i + 0.25 * i), length), 0.25 * i);
  EXPECT_EQ(made, 1 + many);
  EXPECT_EQ(copies.of(line(1, 1.25), length), 0.25);
  EXPECT_EQ(made, 1 + many) << "the first are kept";
  EXPECT_EQ(copies.of(line(many, 1.25 * many), length), 0.25 * many);
  EXPECT_EQ(made, 2 + many) << "the last are not";
}

}  // namespace
}  // namespace ricochet::fem
