#pragma once

#include <limits>
#include <vector>

#include "coupler/report/shapes/shape_files.hpp"

namespace ricochet::report {

/// How displacements are drawn. Small ones cannot be seen to scale, and all of them enlarged would have bodies that fly
/// towards each other pass through each other. The displacement that is enlarged is the one beyond that of the free
/// flight up to the first contact:
///   x = X + u + (factor - 1) (u - v_0 min(t, first contact)),   v_0 of the body.
/// Bodies that touch in the run touch in the picture.
struct Magnification {
  double factor = 1.0;
  double flight_s = 0.0;  ///< end of the free flight; infinite without contact

  [[nodiscard]] Place place(const Place& position, const Place& displacement, const Place& velocity_m_s,
                            double time_s) const;
};

/// 1, 2 or 5 times a power of ten: so that what is enlarged reaches up to 15 % of the bodies' extent. 1 where bodies
/// would not touch as they do in the run: where a gap of the start is closed by something else than free flight, and
/// where the contact has a nose that the mesh has not, where gaps differ over it and where bodies slide.
/// `first_contact_s`, `first_gap_m`: nan if there is none.
[[nodiscard]] Magnification magnification_of(const Shapes& shapes, const std::vector<std::size_t>& windows,
                                             double first_contact_s, double first_gap_m);

}  // namespace ricochet::report
