#include "coupler/study/error_bar.hpp"

#include <algorithm>
#include <cmath>

namespace ricochet::coupler {
namespace {

/// Least of a bar over an extrapolated difference that held the scenes with exact answers (docs/accuracy.md).
constexpr double safety = 2.0, safety_of_slow = 1.5;
constexpr double lowest_order = 0.5, highest_order = 2.0, believed_order = 1.0;

/// Factors from a difference of two levels to a bar, and to the rest of a coarse level's difference on the fine one.
struct Scales {
  double bar = 1.0, coarse = 1.0;
};

std::optional<double> times(double scale, const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return {};
  return scale * std::abs(*a - *b);
}

Scales measure_total(const QuantityLevels& levels, ErrorBar& bar) {
  if (!levels.coarse || !levels.coarsest) return {};
  const double d1 = levels.run - *levels.coarse, d2 = *levels.coarse - *levels.coarsest;
  const double order = d1 * d2 > 0.0 ? std::log2(d2 / d1) : 0.0;
  if (order >= lowest_order && order <= highest_order) {
    const double growth = std::exp2(std::min(order, believed_order));
    bar.order = order;
    bar.found = "converging";
    bar.total = std::max(levels.floor, safety * std::abs(d1) / (growth - 1.0));
    return {safety / (growth - 1.0), 1.0 / growth};
  }
  bar.found = "not converging";
  // A value that goes on in one direction is farther from its limit than one that jumps around it.
  const bool goes_on = d1 * d2 > 0.0 && order < lowest_order;
  bar.total = std::max(levels.floor, (goes_on ? safety_of_slow : 1.0) * (std::abs(d1) + std::abs(d2)));
  return {safety, 1.0};
}

/// For a mesh that cannot be coarsened: by an order of 1, the least of any shipped protocol.
void measure_time_alone(const QuantityLevels& levels, ErrorBar& bar) {
  bar.time = levels.double_step ? times(safety, levels.run, levels.double_step)
                                : times(2.0 * safety, levels.run, levels.half_step);
  bar.found = bar.time ? "time alone" : "unknown";
  if (bar.time) bar.time = std::max(levels.floor, *bar.time);
}

}  // namespace

ErrorBar error_bar(const QuantityLevels& levels) {
  ErrorBar bar;
  const Scales scales = measure_total(levels, bar);
  if (bar.total) {
    bar.time = times(scales.bar, levels.coarse_mesh, levels.coarse);
    bar.space = times(scales.bar, levels.run, levels.coarse_mesh);
    bar.coupling = levels.hybrid ? times(scales.coarse, levels.coarse, levels.coarse_baseline) : 0.0;
    bar.contact_law = times(scales.coarse, levels.coarse, levels.coarse_law);
  } else {
    measure_time_alone(levels, bar);
    if (!levels.hybrid) bar.coupling = 0.0;
  }
  const auto explain = [&](const char* part, const std::optional<double>& value) {
    if (value) return;
    const auto reason = levels.missing.find(part);
    bar.unknown[part] = reason == levels.missing.end() ? "a companion run has no such value" : reason->second;
  };
  explain("total", bar.total);
  explain("time", bar.time);
  explain("space", bar.space);
  explain("coupling", bar.coupling);
  explain("contact_law", bar.contact_law);
  return bar;
}

}  // namespace ricochet::coupler
