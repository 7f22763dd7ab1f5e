#include "explicit_solver/ranks/mpi_communicator.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>

namespace ricochet::explicit_solver {
namespace {

constexpr int tag = 1;
/// MPI counts by int: what is longer goes in pieces.
constexpr std::size_t piece = std::size_t{1} << 30;

std::vector<int> begins(const std::vector<int>& counts) {
  std::vector<int> begin(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, begin.begin() + 1);
  return begin;
}

void send(const std::string& bytes, int rank) {
  std::uint64_t size = bytes.size();
  MPI_Send(&size, 1, MPI_UINT64_T, rank, tag, MPI_COMM_WORLD);
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const int count = static_cast<int>(std::min(piece, bytes.size() - at));
    MPI_Send(bytes.data() + at, count, MPI_CHAR, rank, tag, MPI_COMM_WORLD);
  }
}

std::string received(int rank) {
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, rank, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  std::string bytes(size, '\0');
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    const int count = static_cast<int>(std::min(piece, bytes.size() - at));
    MPI_Recv(bytes.data() + at, count, MPI_CHAR, rank, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  }
  return bytes;
}

}  // namespace

MpiCommunicator::MpiCommunicator(int argc, char** argv) {
  // Ranks wait in turns with the other participants: none keeps a processor to itself, unless the user wants that.
  setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
  // Containers often forbid a process to read another one's memory, which OpenMPI notices in the middle of a message.
  setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 0);
  MPI_Init(&argc, &argv);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
}

MpiCommunicator::~MpiCommunicator() { MPI_Finalize(); }

void MpiCommunicator::abort(int exit_code) {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();  // it does not come back, but does not say so
}

void MpiCommunicator::broadcast(std::string& bytes) {
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
  bytes.resize(size);
  for (std::size_t at = 0; at < bytes.size(); at += piece)
    broadcast(bytes.data() + at, static_cast<int>(std::min(piece, bytes.size() - at)));
}

void MpiCommunicator::broadcast(void* bytes, int size) { MPI_Bcast(bytes, size, MPI_BYTE, 0, MPI_COMM_WORLD); }

void MpiCommunicator::gather(const std::vector<double>& own, const std::vector<int>& counts, std::vector<double>& all) {
  const auto begin = rank_ == 0 ? begins(counts) : std::vector<int>();
  if (rank_ == 0) all.resize(static_cast<std::size_t>(begin.back() + counts.back()));
  MPI_Gatherv(own.data(), static_cast<int>(own.size()), MPI_DOUBLE, all.data(), counts.data(), begin.data(), MPI_DOUBLE,
              0, MPI_COMM_WORLD);
}

std::vector<std::string> MpiCommunicator::gather(const std::string& own) {
  if (rank_ > 0) {
    send(own, 0);
    return {};
  }
  std::vector<std::string> all{own};
  for (int rank = 1; rank < count_; ++rank) all.push_back(received(rank));
  return all;
}

std::string MpiCommunicator::scatter(const std::vector<std::string>& all) {
  if (rank_ > 0) return received(0);
  for (int rank = 1; rank < count_; ++rank) send(all[static_cast<std::size_t>(rank)], rank);
  return all.front();
}

bool MpiCommunicator::any(bool own) {
  int mine = own ? 1 : 0, found = 0;
  MPI_Allreduce(&mine, &found, 1, MPI_INT, MPI_LOR, MPI_COMM_WORLD);
  return found != 0;
}

void MpiCommunicator::start(const std::vector<Message>& out, std::vector<Message>& in) {
  requests_.clear();
  for (auto& message : in) {
    MPI_Irecv(message.values.data(), static_cast<int>(message.values.size()), MPI_DOUBLE, message.rank, tag,
              MPI_COMM_WORLD, &requests_.emplace_back());
  }
  for (const auto& message : out) {
    MPI_Isend(message.values.data(), static_cast<int>(message.values.size()), MPI_DOUBLE, message.rank, tag,
              MPI_COMM_WORLD, &requests_.emplace_back());
  }
}

void MpiCommunicator::finish() {
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
}

}  // namespace ricochet::explicit_solver
