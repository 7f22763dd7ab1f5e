#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "coupler/interface/peer.hpp"

namespace ricochet::coupler {

/// Which shared node each interface node of one participant is. Vectors are row-major, `components` columns.
class InterfaceRows {
 public:
  /// `shared`: per own interface node its shared node.
  explicit InterfaceRows(std::vector<int> shared = {}, int components = 1);
  [[nodiscard]] std::size_t nodes() const { return nodes_; }  ///< own ones
  [[nodiscard]] int components() const { return components_; }
  /// Whether the own nodes are all `nodes` shared ones in their order.
  [[nodiscard]] bool all_in_order(std::size_t nodes) const { return nodes_ == nodes && blocks_.size() <= 1; }

  /// Per own degree of freedom the shared one.
  [[nodiscard]] std::vector<std::size_t> dofs() const;
  /// Per own node, of a value per shared node.
  [[nodiscard]] std::vector<double> per_node(const std::vector<double>& shared_values) const;
  /// own[i] = shared[rows[i]].
  void gather(const std::vector<double>& shared_values, std::vector<double>& own_values) const;
  /// shared[rows[i]] = own[i]: for the one participant that integrates the shared nodes.
  void scatter(const std::vector<double>& own_values, std::vector<double>& shared_values) const;
  /// shared[rows[i]] += own[i]: forces of all participants that meet at a node.
  void add(const std::vector<double>& own_values, std::vector<double>& shared_values) const;
  /// The same of a matrix, own degrees of freedom x own degrees of freedom.
  void add_matrix(const Eigen::MatrixXd& own, Eigen::MatrixXd& shared_matrix) const;

 private:
  /// Numbers that lie one behind the other on both sides: `count` from the own `own` and the shared `shared` on.
  struct Block {
    std::size_t own, shared, count;
  };
  template <class Own, class Shared, class Each>
  void each_number(Own* own_values, Shared* shared_values, Each each) const;

  std::vector<int> shared_;
  std::size_t nodes_;
  int components_;
  std::vector<Block> blocks_;
};

/// Which nodes of the participants are one node of the structure, and its mass (Eq. 28: the sum of the lumped masses of
/// all partitions that share it). Nodes are the same if they belong to the same body and lie within 1e-9 of the extent
/// of all interface nodes. The shared numbering is that of the first implicit participant, and masses are summed in the
/// order of the participants, so that neither depends on how explicit bodies are spread over processes.
class InterfaceMap {
 public:
  /// `descriptions`: one message of kind `description` per participant, in the scene's order.
  /// Throws ProtocolError naming participant, body and position where a node has no partner, two nodes of one
  /// participant coincide, no participant (or more than one) integrates it, or components differ.
  explicit InterfaceMap(const std::vector<PeerDescription>& descriptions);

  /// Nodes this close are one, in shares of the largest extent or coordinate of all interface nodes.
  static constexpr double same_place = 1e-9;
  /// Sums of more, and what is divided by them, leave the range of numbers.
  static constexpr double largest_mass_kg = 1e30;

  [[nodiscard]] int nodes() const { return static_cast<int>(mass_kg_.size()); }
  [[nodiscard]] int components() const { return components_; }
  /// Largest extent of all nodes along a coordinate, or largest coordinate, if that is more [m].
  [[nodiscard]] double extent_m() const { return extent_m_; }
  [[nodiscard]] const InterfaceRows& rows(std::size_t participant) const { return rows_[participant]; }
  [[nodiscard]] const std::vector<double>& mass_kg() const { return mass_kg_; }

 private:
  std::vector<InterfaceRows> rows_;
  std::vector<double> mass_kg_;
  int components_ = 1;
  double extent_m_ = 0.0;
};

}  // namespace ricochet::coupler
