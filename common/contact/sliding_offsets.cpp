// The quantities that rows keep when they are written anew, of those before: the work of forces, and where pairs touch.
#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "common/contact/sliding_rows.hpp"

namespace ricochet::solver {

double SlidingRows::Slide::own_of(const Pair& pair) const {
  for (const Own& one : own)
    if (one.node == pair.own_node() && one.patch == pair.patch) return one.offset_m;
  return 0.0;
}

/// Finds the offsets of contacts that have changed; `pairs` are without them.
void SlidingRows::balance(const std::vector<Pair>& before, const std::vector<PairForce>& forces,
                          const std::vector<BodyState>& states, double middle_s, const std::vector<Pair>& pairs) {
  const auto gap = [&](const Pair& pair) {
    return pair.gap(displacement_of(states)) + middle_s * pair.normal.times(velocity_of(states));
  };
  const std::vector<int> same = same_pairs(before, pairs);
  for (auto& sliding : contacts_) {
    const auto& geometry = problem_->contacts[sliding.contact];
    if (!sliding.changed || geometry.flat) continue;
    Slide& slide = sliding.slide;
    double work_j = 0.0, force_n = 0.0;
    std::vector<Slide::Own> own;
    const auto keep = [&own](const Pair& pair, double offset_m) {
      if (offset_m > 0.0) own.push_back({pair.own_node(), pair.patch, offset_m});
    };
    const auto force_of = [&](std::size_t i) {
      return same[i] < 0 ? 0.0 : forces[static_cast<std::size_t>(same[i])].normal;
    };
    const auto was_m = [&](std::size_t i) { return gap(before[static_cast<std::size_t>(same[i])]); };
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double force = force_of(i);
      if (pairs[i].contact != sliding.contact || !(force > 0.0)) continue;
      const double own_m = slide.own_of(pairs[i]);
      keep(pairs[i], own_m);
      work_j += force * (was_m(i) - (gap(pairs[i]) + own_m));
      force_n += force;
    }
    const double most_m = slide_share * geometry.sliding->edge_m;
    slide.offset_m = force_n > 0.0 ? std::clamp(work_j / force_n, -most_m, most_m) : 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (pairs[i].contact != sliding.contact || force_of(i) > 0.0) continue;
      keep(pairs[i], (same[i] < 0 ? 0.0 : std::min(was_m(i), 0.0)) - (gap(pairs[i]) + slide.offset_m));
    }
    slide.own = std::move(own);
  }
}

void SlidingRows::offset(std::vector<Pair>& pairs) {
  for (auto& sliding : contacts_) {
    if (!sliding.changed) continue;
    for (Pair& pair : pairs) {
      if (pair.contact != sliding.contact) continue;
      pair.gap0_m += sliding.slide.offset_m + sliding.slide.own_of(pair);
    }
    sliding.changed = false;
  }
}

std::vector<int> same_pairs(const std::vector<Pair>& from, const std::vector<Pair>& to) {
  const auto key = [](const Pair& pair) { return std::tuple(pair.contact, pair.own_node(), pair.patch); };
  std::map<std::tuple<std::size_t, int, int>, int> known;
  for (std::size_t i = 0; i < from.size(); ++i) known[key(from[i])] = static_cast<int>(i);
  std::vector<int> same;
  for (const auto& pair : to) {
    const auto found = known.find(key(pair));
    same.push_back(found == known.end() ? -1 : found->second);
  }
  return same;
}

}  // namespace ricochet::solver
