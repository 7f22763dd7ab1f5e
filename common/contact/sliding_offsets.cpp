// What rows that are written anew keep of those before: the work of forces, and where pairs touch.
#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "common/contact/sliding_rows.hpp"

namespace ricochet::solver {

/// Finds the offsets of contacts that have changed; `pairs` are without them.
void SlidingRows::balance(const std::vector<Pair>& before, const std::vector<PairForce>& forces,
                          const std::vector<BodyState>& states, double middle_s, const std::vector<Pair>& pairs) {
  struct Jump {
    double work_j = 0.0, force_n = 0.0;
    double overlap_m = 0.0;  ///< that rows make where no force is
    std::vector<Slide::Own> own;
  };
  const auto gap = [&](const Pair& pair) {
    return pair.gap(displacement_of(states)) + middle_s * pair.normal.times(velocity_of(states));
  };
  const auto own_of = [&](const Pair& pair) {
    for (const auto& sliding : contacts_) {
      if (sliding.contact != pair.contact) continue;
      for (const auto& own : sliding.slide.own)
        if (own.node == pair.node_a && own.patch == pair.patch) return own.offset_m;
    }
    return 0.0;
  };
  std::vector<Jump> jumps(problem_->contacts.size());
  const std::vector<int> same = same_pairs(before, pairs);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Jump& jump = jumps[pairs[i].contact];
    const auto old = static_cast<std::size_t>(same[i]);
    const bool pressed = same[i] >= 0 && forces[old].normal > 0.0;
    double now_m = gap(pairs[i]);
    const double overlap_m = std::max(0.0, -now_m), own_m = same[i] < 0 ? overlap_m
                                                            : pressed   ? own_of(pairs[i])
                                                                        : std::min(own_of(pairs[i]), overlap_m);
    if (own_m > 0.0) jump.own.push_back({pairs[i].node_a, pairs[i].patch, own_m});
    now_m += own_m;
    const double was_m = same[i] < 0 ? 0.0 : gap(before[old]);
    if (!pressed) {
      jump.overlap_m = std::max(jump.overlap_m, std::min(was_m, 0.0) - std::min(now_m, 0.0));
    } else {
      jump.work_j += forces[old].normal * (was_m - now_m);
      jump.force_n += forces[old].normal;
    }
  }
  for (auto& sliding : contacts_) {
    const auto& geometry = problem_->contacts[sliding.contact];
    if (!sliding.changed || geometry.flat) continue;
    Jump& jump = jumps[sliding.contact];
    const double most_m = slide_share * geometry.sliding->edge_m;
    double& offset_m = sliding.slide.offset_m;
    offset_m =
        jump.force_n > 0.0 ? std::clamp(jump.work_j / jump.force_n, -most_m, most_m) : std::min(jump.overlap_m, most_m);
    sliding.slide.own = std::move(jump.own);
  }
}

void SlidingRows::offset(std::vector<Pair>& pairs) {
  for (auto& sliding : contacts_) {
    if (!sliding.changed) continue;
    for (Pair& pair : pairs) {
      if (pair.contact != sliding.contact) continue;
      pair.gap0_m += sliding.slide.offset_m;
      for (const auto& own : sliding.slide.own)
        if (own.node == pair.node_a && own.patch == pair.patch) pair.gap0_m += own.offset_m;
    }
    sliding.changed = false;
  }
}

std::vector<int> same_pairs(const std::vector<Pair>& from, const std::vector<Pair>& to) {
  const auto key = [](const Pair& pair) { return std::tuple(pair.contact, pair.node_a, pair.patch); };
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
