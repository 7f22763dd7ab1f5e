#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <random>
#include <string>
#include <thread>
#include <vector>

/// Hosts on one machine: network namespaces with a cable between them that tests can worsen and cut.
namespace ricochet::test {

/// A cable between two network cards. Frames take `delay` and a share of them, `loss`, never arrives; none does while
/// it is cut, and neither end is told. It is this process that carries them, from one tap device to the other, because
/// not every kernel has a queueing discipline that could.
class Cable {
 public:
  /// Two cards of these names, in the namespace of this process. Throws std::runtime_error if that is not allowed.
  Cable(const std::string& card, const std::string& other_card);
  Cable(const Cable&) = delete;
  Cable& operator=(const Cable&) = delete;
  ~Cable();

  void worsen(std::chrono::microseconds delay, double loss);
  void cut() { cut_ = true; }
  void restore() { cut_ = false; }
  [[nodiscard]] long carried() const { return carried_; }
  [[nodiscard]] long lost() const { return lost_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Frame {
    Clock::time_point due;
    int from;
    std::vector<char> bytes;
  };
  void carry(const std::stop_token& stop);
  void take(int from);
  void deliver();

  int ends_[2] = {-1, -1};
  std::deque<Frame> under_way_;
  std::mt19937 random_{1};
  std::atomic<long> delay_us_ = 0, carried_ = 0, lost_ = 0;
  std::atomic<double> loss_ = 0.0;
  std::atomic<bool> cut_ = false;
  std::jthread carrier_;
};

/// Two hosts, each with its name and an address of its own, and a cable between them; gone with this object.
class TwoHosts {
 public:
  /// Why there can be none; empty if there can.
  [[nodiscard]] static std::string obstacle();
  TwoHosts();
  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;
  ~TwoHosts();

  /// Words in front of a command that is to run on host 0 or 1.
  [[nodiscard]] std::vector<std::string> on(int host) const;
  [[nodiscard]] std::string name(int host) const;
  [[nodiscard]] static std::string address(int host);
  [[nodiscard]] Cable& cable() { return cable_; }

 private:
  Cable cable_;
};

}  // namespace ricochet::test
