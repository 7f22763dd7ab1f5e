#pragma once

#include "common/scene/body.hpp"

/// What bodies that yield or turn take beside linear ones: the rounded striker that yields (docs/studies.md) and discs
/// that spin (docs/limits.md), while bodies touch.
namespace ricochet::cost {

/// Of an explicit step: looking at elements that may yield and returning those that do; finding the frame of a body.
inline double nonlinear_step_s(const scene::Body& body, double elements, double unknowns) {
  constexpr double yielding_element_s = 30e-9, turning_unknown_s = 25e-9;
  return (body.yields() ? yielding_element_s * elements : 0.0) +
         (body.large_rotation ? turning_unknown_s * unknowns : 0.0);
}

/// Of a product with the rows that step locally: what flows is spread over the small steps once more.
inline double spreads(const scene::Body& body) { return body.yields() ? 1.6 : 1.0; }

/// Of an implicit window: improvements of its solution, each a solve.
inline double solves(const scene::Body& body) { return body.yields() ? 20.0 : body.large_rotation ? 10.0 : 1.0; }

}  // namespace ricochet::cost
