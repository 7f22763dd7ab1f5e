#pragma once

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "explicit_solver/ranks/first_rank.hpp"

/// Ranks that are threads of this process, so that a debugger and the sanitizers see all of them.
namespace ricochet::test {

/// The messages that ranks have sent each other and not yet taken.
class Mailboxes {
 public:
  void send(int from, int to, std::string bytes) {
    const std::lock_guard lock(mutex_);
    boxes_[{from, to}].push_back(std::move(bytes));
    arrived_.notify_all();
  }
  std::string take(int from, int to) {
    std::unique_lock lock(mutex_);
    auto& box = boxes_[{from, to}];
    if (!arrived_.wait_for(lock, std::chrono::seconds(30), [&] { return !box.empty(); }))
      throw std::runtime_error("a rank waits in vain");
    std::string bytes = std::move(box.front());
    box.pop_front();
    return bytes;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::map<std::pair<int, int>, std::deque<std::string>> boxes_;
};

class ThreadCommunicator final : public explicit_solver::Communicator {
 public:
  ThreadCommunicator(Mailboxes& mail, int rank, int count) : mail_(mail), rank_(rank), count_(count) {}

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return count_; }
  void broadcast(std::string& bytes) override {
    if (rank_ > 0) bytes = mail_.take(0, rank_);
    for (int to = 1; rank_ == 0 && to < count_; ++to) mail_.send(0, to, bytes);
  }
  void broadcast(void* bytes, int size) override {
    std::string text(static_cast<const char*>(bytes), static_cast<std::size_t>(size));
    broadcast(text);
    std::memcpy(bytes, text.data(), text.size());
  }
  void gather(const std::vector<double>& own, const std::vector<int>& counts, std::vector<double>& all) override {
    const auto texts = gather(text_of(own));
    if (rank_ > 0) return;
    all.clear();
    for (std::size_t rank = 0; rank < texts.size(); ++rank) {
      const auto values = values_of(texts[rank]);
      if (static_cast<int>(values.size()) != counts[rank]) throw std::runtime_error("another size than was said");
      all.insert(all.end(), values.begin(), values.end());
    }
  }
  [[nodiscard]] std::vector<std::string> gather(const std::string& own) override {
    if (rank_ > 0) mail_.send(rank_, 0, own);
    if (rank_ > 0) return {};
    std::vector<std::string> all{own};
    for (int from = 1; from < count_; ++from) all.push_back(mail_.take(from, 0));
    return all;
  }
  [[nodiscard]] std::string scatter(const std::vector<std::string>& all) override {
    if (rank_ > 0) return mail_.take(0, rank_);
    for (int to = 1; to < count_; ++to) mail_.send(0, to, all[static_cast<std::size_t>(to)]);
    return all.front();
  }
  [[nodiscard]] bool any(bool own) override {
    bool found = false;
    for (const auto& text : gather(std::string(1, own ? '1' : '0'))) found = found || text == "1";
    std::string said(1, found ? '1' : '0');
    broadcast(said);
    return said == "1";
  }
  void start(const std::vector<Message>& out, std::vector<Message>& in) override {
    for (const auto& message : out) mail_.send(rank_, message.rank, text_of(message.values));
    awaited_ = &in;
  }
  void finish() override {
    for (auto& message : *awaited_) {
      const auto values = values_of(mail_.take(message.rank, rank_));
      if (values.size() != message.values.size()) throw std::runtime_error("another size than was said");
      message.values = values;
    }
  }

 private:
  static std::string text_of(const std::vector<double>& values) {
    return {reinterpret_cast<const char*>(values.data()), sizeof(double) * values.size()};
  }
  static std::vector<double> values_of(const std::string& text) {
    std::vector<double> values(text.size() / sizeof(double));
    if (!text.empty()) std::memcpy(values.data(), text.data(), text.size());
    return values;
  }
  Mailboxes& mail_;
  int rank_, count_;
  std::vector<Message>* awaited_ = nullptr;
};

/// The first rank, for a solver in this thread, and the others in threads of their own.
class RanksInThreads {
 public:
  RanksInThreads(const scene::Problem& problem, const std::string& participant, int count)
      : own_(mail_, 0, count), first(own_) {
    for (int rank = 1; rank < count; ++rank) {
      threads_.emplace_back([this, &problem, participant, rank, count] {
        ThreadCommunicator communicator(mail_, rank, count);
        std::string said;
        communicator.broadcast(said);
        if (!said.empty()) explicit_solver::follow(problem, participant, said, communicator);
      });
    }
  }
  ~RanksInThreads() {
    std::string nothing;
    if (!first.begun()) own_.broadcast(nothing);
    if (first.going_on()) first.tell(explicit_solver::Order::end);
    for (auto& thread : threads_) thread.join();
  }
  RanksInThreads(const RanksInThreads&) = delete;
  RanksInThreads& operator=(const RanksInThreads&) = delete;

 private:
  Mailboxes mail_;
  ThreadCommunicator own_;
  std::vector<std::thread> threads_;

 public:
  explicit_solver::FirstRank first;
};

}  // namespace ricochet::test
