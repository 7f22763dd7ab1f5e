#pragma once

#include <Eigen/Core>
#include <functional>

namespace ricochet::solver {

struct BodyState;
struct Moments;

/// Sums that a process which steps its share of a part asks of those that step the rest. Every rank makes the same
/// calls in the same order.
class OtherRanks {
 public:
  virtual ~OtherRanks() = default;
  /// The displacement [m] of own nodes that rows of others read goes out; `receive` waits for that of their nodes which
  /// rows here read, and writes it into `u`. In between K u can be computed where it reads none of those.
  virtual void send(const Eigen::VectorXd& u) = 0;
  virtual void receive(Eigen::VectorXd& u) = 0;
  /// Both at once.
  void exchange(Eigen::VectorXd& u) {
    send(u);
    receive(u);
  }

  /// The sum over all blocks of the whole part, one after another, of so many numbers each, on every rank.
  /// `of_block(block, numbers)` writes those of an own block.
  using OfBlock = std::function<void(int block, double* numbers)>;
  virtual void sum(int numbers, const OfBlock& of_block, double* sums) = 0;

  /// For bodies that slide along each other: collects the moments of the whole part at u on the first rank.
  virtual void collect_moments(const BodyState& state) = 0;
  [[nodiscard]] virtual const Moments& moments() const = 0;
  /// Whether it is so on any rank.
  [[nodiscard]] virtual bool anywhere(bool here) = 0;

  /// Entry of one degree of freedom: the mean force [N] while it moves [m], its component, and where it is.
  using Book = std::function<void(double force, double moved, int component, const Eigen::Vector3d& place)>;
  /// Calls `book` on the first rank for all degrees of freedom of the whole part that are booked, in the order in which
  /// a process that has the whole part does; `force`, `moved` and `place` are asked for own ones on every rank.
  virtual void book(const std::function<double(int dof)>& force, const std::function<double(int dof)>& moved,
                    const std::function<Eigen::Vector3d(int dof)>& place, const Book& book) = 0;
};

}  // namespace ricochet::solver
