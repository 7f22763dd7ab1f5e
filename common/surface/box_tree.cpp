#include "common/surface/box_tree.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ricochet::surface {
namespace {
constexpr std::size_t undivided = 4;
}

BoxTree::BoxTree(std::vector<Eigen::AlignedBox3d> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (boxes_.empty()) return;
  halves_.push_back({{}, 0, boxes_.size()});
  for (std::size_t i = 0; i < halves_.size(); ++i) divide(i);
}

void BoxTree::divide(std::size_t half) {
  const std::size_t begin = halves_[half].begin, end = halves_[half].end, middle = begin + (end - begin) / 2;
  Eigen::AlignedBox3d box;
  for (std::size_t i = begin; i < end; ++i) box.extend(boxes_[order_[i]]);
  halves_[half].box = box;
  if (end - begin <= undivided) return;
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](std::size_t i, std::size_t j) {
    return std::pair(boxes_[i].center()[axis], i) < std::pair(boxes_[j].center()[axis], j);
  });
  halves_[half].below = halves_.size();
  halves_.push_back({{}, begin, middle});
  halves_.push_back({{}, middle, end});
}

}  // namespace ricochet::surface
