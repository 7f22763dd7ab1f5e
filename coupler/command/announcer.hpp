#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace ricochet::coupler {

/// Says on stderr what is being done once that has taken 2 s, and every 2 s from then on: before a process is started
/// nobody else does.
class Announcer {
 public:
  Announcer();
  ~Announcer();
  Announcer(const Announcer&) = delete;
  Announcer& operator=(const Announcer&) = delete;

  void begin(const std::string& doing);

 private:
  void watch();

  std::mutex mutex_;
  std::condition_variable end_;
  bool over_ = false;
  std::string doing_;
  std::thread thread_;  ///< last, since it uses all others
};

}  // namespace ricochet::coupler
