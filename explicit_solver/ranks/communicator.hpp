#pragma once

#include <string>
#include <vector>

namespace ricochet::explicit_solver {

/// How the ranks of a participant talk to each other. All ranks make the same calls in the same order.
class Communicator {
 public:
  virtual ~Communicator() = default;
  [[nodiscard]] virtual int rank() const = 0;  ///< 0 is the first
  [[nodiscard]] virtual int count() const = 0;

  /// The first rank's bytes to all.
  virtual void broadcast(std::string& bytes) = 0;
  /// Gives `size` bytes of the first rank to all.
  virtual void broadcast(void* bytes, int size) = 0;
  /// Numbers of all ranks, one rank after another, to the first. `counts`: how many each has, on the first.
  virtual void gather(const std::vector<double>& own, const std::vector<int>& counts, std::vector<double>& all) = 0;
  [[nodiscard]] virtual std::vector<std::string> gather(const std::string& own) = 0;
  /// To each rank its own of what the first has.
  [[nodiscard]] virtual std::string scatter(const std::vector<std::string>& all) = 0;
  /// Whether any has true.
  [[nodiscard]] virtual bool any(bool own) = 0;

  struct Message {
    int rank = 0;  ///< to or from whom
    std::vector<double> values;
  };
  /// Messages begin to go out and to come in, of the size that they have; `finish` waits until all have.
  virtual void start(const std::vector<Message>& out, std::vector<Message>& in) = 0;
  virtual void finish() = 0;
};

}  // namespace ricochet::explicit_solver
