#pragma once

#include <Eigen/Core>

#include "common/fem/mesh.hpp"

namespace ricochet::fem {

/// A box of a mesh's own coordinates [m], whose elements are divided.
struct RefinedBox {
  Eigen::Vector3d from_m, to_m;
  int ratio = 2;  ///< elements along each edge of one that is divided
};

/// Divides the elements whose middle lies in the box, along each edge into `ratio` of equal length in the element's
/// natural coordinates. The new nodes on an edge or a face of an element that is not divided hang on it
/// (hanging_nodes.hpp). Parts of an element belong to its groups, those of a face to its surfaces. The nodes of the
/// parts are numbered last.
/// Throws ConfigError for a box without an element, for tetrahedra in it, and for an element there with a node that
/// hangs already: between two sizes of elements there must be a whole layer of the middle one.
void refine(Mesh& mesh, const RefinedBox& box);

}  // namespace ricochet::fem
