#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

#include "common/surface/box_tree.hpp"

namespace ricochet::surface {
namespace {

/// The boxes that a question reaches are those found one by one, and few others are asked for.
TEST(BoxTree, VisitsTheBoxesThatAQuestionReaches) {
  std::mt19937 random(1);  // NOLINT: the same in every run
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::vector<Eigen::AlignedBox3d> boxes;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d corner(place(random), place(random), place(random));
    boxes.emplace_back(corner, corner + Eigen::Vector3d::Constant(0.02));
  }
  const BoxTree tree(boxes);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d corner(place(random), place(random), place(random));
    const Eigen::AlignedBox3d asked(corner, corner + Eigen::Vector3d::Constant(0.05));
    std::set<std::size_t> expected, found;
    for (std::size_t i = 0; i < boxes.size(); ++i)
      if (boxes[i].intersects(asked)) expected.insert(i);
    int questions = 0;
    tree.visit([&](const Eigen::AlignedBox3d& box) { return ++questions, box.intersects(asked); },
               [&](std::size_t i) { EXPECT_TRUE(found.insert(i).second); });
    EXPECT_EQ(found, expected);
    EXPECT_LT(questions, 250);
  }
  BoxTree({}).visit([](const Eigen::AlignedBox3d&) { return true; }, [](std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace ricochet::surface
