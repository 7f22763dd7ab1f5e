#include "coupler/command/announcer.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

namespace ricochet::coupler {
namespace {

constexpr std::chrono::seconds interval{2};

}  // namespace

Announcer::Announcer() : thread_([this] { watch(); }) {}

Announcer::~Announcer() {
  {
    const std::lock_guard lock(mutex_);
    over_ = true;
  }
  end_.notify_all();
  thread_.join();
}

void Announcer::begin(const std::string& doing) {
  const std::lock_guard lock(mutex_);
  doing_ = doing;
}

void Announcer::watch() {
  const auto began = std::chrono::steady_clock::now();
  std::unique_lock lock(mutex_);
  while (!end_.wait_for(lock, interval, [this] { return over_; })) {
    const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    fmt::print(stderr, "{:.0f} s: {}\n", s, doing_);
    std::fflush(stderr);
  }
}

}  // namespace ricochet::coupler
