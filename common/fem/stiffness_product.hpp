#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/parallel.hpp"
#include "common/fem/node_stencils.hpp"

namespace ricochet::fem {

/// The numbering of a larger part that a part is a share of: its number of each node, ascending, and how many nodes it
/// has. Slices of the larger part must be slices of the share; then sums run in its order, to its bits.
struct Numbering {
  std::vector<int> number;
  int count = 0;
};

/// K u, the explicit solver's inner loop, for a fixed symmetric K of two or three components per node (of one: row by
/// row). Three are the affair of NodeStencils.
///
/// With two components, four nodes, eight degrees of freedom, are one slice. A *slot* of a slice holds one neighbour of
/// each of its four nodes as two vectors of coefficients: those that multiply the neighbour's same component (xx, yy,
/// xx, yy, ...) and those that multiply the other one (xy, yx, ...), so that a slot is y += same * u_neighbour + cross
/// * swap(u_neighbour). Where the four neighbours are numbered in a row, as in most of any well-numbered mesh,
/// u_neighbour is one load; elsewhere it is put together from four. Sums run in a fixed order: the same part gives the
/// same bits everywhere. Slices among copies of the same elements, as structured, swept and periodic meshes are made
/// of, have the same slots, which are stored once (matrix_places makes copies equal to the last bit).
///
/// A translation makes no force: where K maps a constant component to zero, a row takes u relative to its own node.
/// Else the rounding of K u, which grows with the distance travelled, would push a body in free flight (momentum error
/// like time^2).
class StiffnessProduct {
 public:
  StiffnessProduct() = default;
  explicit StiffnessProduct(const SparseMatrix& stiffness, int components, const Numbering& numbering = {});

  /// result = K u [N]; both of K's size, different vectors.
  void multiply(const Eigen::VectorXd& u, Eigen::VectorXd& result) const;
  /// The same in the rows first ... last - 1 only, to the same bits. `first` is the first row of a slice, `last` the
  /// end of one (of the last slice: the number of rows).
  void multiply(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const;

  /// From here on computes with these threads where rows are many. A row is one thread's: the bits stay the same.
  void compute_with(std::shared_ptr<Parallel> parallel) { parallel_ = std::move(parallel); }

  /// As fine as the rows can be chosen; whole nodes of two and three components.
  [[nodiscard]] static constexpr int rows_of_slice(int components) { return components == 3 ? 24 : plane_slice; }
  /// Whether rows take this component relative to their own node.
  [[nodiscard]] bool translation_is_free(int component) const { return follows_[component] != 0.0; }

  /// Share of the stored slots whose four neighbours are one load.
  [[nodiscard]] double contiguous_share() const;
  /// The slices of two components: how many there are, and how many are stored.
  [[nodiscard]] int slices() const { return static_cast<int>(slots_of_.size()); }
  [[nodiscard]] int distinct_slices() const { return static_cast<int>(start_.size()) - 1; }

 private:
  static constexpr int plane_slice = 8;
  /// A neighbour of each of four nodes: how far its first dof is from the slice's.
  struct Slot {
    std::array<int, 4> distance{};
    bool in_a_row = false;  ///< then the first one's alone
    bool operator==(const Slot&) const = default;
  };
  struct Coefficients {
    alignas(64) double same[8] = {};
    alignas(64) double cross[8] = {};
  };
  /// The numbers that slices with the same neighbours and the same coefficients share.
  struct Slots {
    std::vector<Slot> slots;
    std::vector<Coefficients> coefficients;  ///< one per slot
  };
  class Builder;
  void multiply_here(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const;
  void multiply_slices(int first, int end, const double* u, double* result) const;
  void multiply_slices_by_avx2(int first, int end, const double* u, double* result) const;
  template <int width>
  void multiply_slice(int slice, const double* u, double* result) const;
  void multiply_rows(const Eigen::VectorXd& u, Eigen::VectorXd& result, int first, int last) const;
  template <int components>
  void multiply_rows_of(const double* u, double* result, int first, int last) const;

  std::shared_ptr<Parallel> parallel_;  ///< null: nobody but the caller
  std::vector<int> slots_of_;           ///< per slice
  std::vector<int> start_{0};           ///< slots_of_[s] = k: slots start_[k] .. start_[k + 1]
  std::vector<Slot> slots_;
  std::vector<Coefficients> coefficients_;  ///< one per slot
  NodeStencils stencils_;                   ///< of three components
  SparseMatrix rows_;                       ///< rows behind the last whole slice, or all of one component
  int first_row_ = 0;                       ///< row of the first of rows_
  int components_ = 1;
  double follows_[3] = {0.0, 0.0, 0.0};  ///< per component 1: u is taken relative to the row's node; 0: as it is
};

}  // namespace ricochet::fem
