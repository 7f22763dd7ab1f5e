#pragma once

#include <mpi.h>

#include <string>
#include <vector>

#include "explicit_solver/ranks/communicator.hpp"

namespace ricochet::explicit_solver {

/// All processes that mpirun or srun started together. MPI ends them all if a call fails or one of them dies.
class MpiCommunicator final : public Communicator {
 public:
  MpiCommunicator(int argc, char** argv);
  MpiCommunicator(const MpiCommunicator&) = delete;
  MpiCommunicator& operator=(const MpiCommunicator&) = delete;
  ~MpiCommunicator() override;

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return count_; }
  void broadcast(std::string& bytes) override;
  void broadcast(void* bytes, int size) override;
  void gather(const std::vector<double>& own, const std::vector<int>& counts, std::vector<double>& all) override;
  [[nodiscard]] std::vector<std::string> gather(const std::string& own) override;
  [[nodiscard]] std::string scatter(const std::vector<std::string>& all) override;
  [[nodiscard]] bool any(bool own) override;
  void start(const std::vector<Message>& out, std::vector<Message>& in) override;
  void finish() override;
  /// Ends all ranks with this exit code.
  [[noreturn]] void abort(int exit_code);

 private:
  int rank_ = 0, count_ = 1;
  std::vector<MPI_Request> requests_;
};

}  // namespace ricochet::explicit_solver
