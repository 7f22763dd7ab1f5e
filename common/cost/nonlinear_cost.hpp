#pragma once

#include "common/scene/body.hpp"

/// Bodies that yield or turn take more than linear ones. Constants are from the rounded striker that yields
/// (docs/studies.md) and discs that spin (docs/limits.md), while bodies touch.
namespace ricochet::cost {

/// An explicit step looks at elements that may yield and returns those that do, and finds the frame of a body [s].
inline double nonlinear_step_s(const scene::Body& body, double elements, double unknowns) {
  constexpr double yielding_element_s = 30e-9, turning_unknown_s = 12e-9;
  return (body.yields() ? yielding_element_s * elements : 0.0) +
         (body.large_rotation ? turning_unknown_s * unknowns : 0.0);
}

/// Small steps are taken once more for what flows: products with their rows, over those of a linear body [1].
inline double spreads(const scene::Body& body) { return body.yields() ? 1.6 : 1.0; }

/// An implicit window is solved so many times, with a look at what yields each time [1].
inline double solves(const scene::Body& body) { return body.yields() ? 7.0 : body.large_rotation ? 3.0 : 1.0; }

}  // namespace ricochet::cost
