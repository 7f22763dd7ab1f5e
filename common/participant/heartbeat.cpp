#include "common/participant/heartbeat.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <exception>
#include <utility>

namespace ricochet::participant {
namespace {

constexpr std::chrono::seconds interval{1};
/// Less of a processor than this share of the time is no work.
constexpr double least_share = 0.02;
constexpr double almost_done = 0.99;  // of what is only estimated

/// Processor time of all threads of this process [s].
double used_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

Heartbeat::Heartbeat(TellProgress tell) : tell_(std::move(tell)), began_s_(used_s()) {
  if (tell_) thread_ = std::thread([this] { beat(); });
}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  end_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Heartbeat::begin(const std::string& doing, double expected_s) {
  const std::lock_guard lock(mutex_);
  doing_ = doing;
  began_s_ = used_s();
  expected_s_ = expected_s;
}

void Heartbeat::beat() {
  std::unique_lock lock(mutex_);
  double last_s = used_s();
  while (!end_.wait_for(lock, interval, [this] { return over_; })) {
    const double now_s = used_s();
    const bool works = now_s - last_s > least_share * std::chrono::duration<double>(interval).count();
    last_s = now_s;
    if (!works) continue;
    try {
      tell_(doing_, expected_s_ > 0.0 ? std::min(almost_done, (now_s - began_s_) / expected_s_) : -1.0);
    } catch (const std::exception&) {
      return;  // who computes hears of a coupler that is gone when it answers
    }
  }
}

}  // namespace ricochet::participant
