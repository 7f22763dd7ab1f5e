#include "coupler/run/checkpoints.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/process.hpp"

namespace ricochet::coupler {
namespace {

constexpr std::chrono::milliseconds look_every{200};  // for the file of a request

}  // namespace

Checkpoints::Checkpoints(const scene::Checkpointing& settings, std::string folder, FieldDigests fields,
                         Launcher& launcher)
    : settings_(settings), folder_(std::move(folder)), fields_(std::move(fields)), launcher_(launcher) {
  launcher_.take_requests();
}

Checkpoints::~Checkpoints() {
  settle();
  std::error_code ignored;
  std::filesystem::remove(folder_.path() + "/" + request_name, ignored);
}

bool Checkpoints::writing() const {
  return written_.valid() && written_.wait_for(std::chrono::seconds(0)) != std::future_status::ready;
}

bool Checkpoints::requested(Clock::time_point now) {
  if (now - looked_ < look_every) return false;
  looked_ = now;
  std::error_code ignored;
  return std::filesystem::exists(folder_.path() + "/" + request_name, ignored);
}

Checkpoints::Due Checkpoints::due(std::int64_t window) {
  const int signal = launcher_.take_request();
  if (signal == SIGTERM) return Due::last;
  const auto now = Clock::now();
  answers_request_ = requested(now);
  if (signal == SIGUSR1 || answers_request_) return Due::yes;
  const bool by_windows = settings_.every_windows > 0 && window % settings_.every_windows == 0;
  const bool by_time = settings_.every_s > 0 && now - begun_ >= std::chrono::duration<double>(settings_.every_s);
  return (by_windows || by_time) && !writing() ? Due::yes : Due::no;
}

void Checkpoints::begin(Checkpoint checkpoint) {
  settle();
  begun_ = Clock::now();
  window_ = checkpoint.window;
  auto write = [this, checkpoint = std::move(checkpoint), answers = answers_request_]() mutable {
    std::string trouble;
    try {
      checkpoint.fields = fields_.take(checkpoint.window);
      folder_.write(checkpoint);
    } catch (const std::exception& error) {
      trouble = text_of(error);
    }
    std::error_code ignored;
    if (answers) std::filesystem::remove(folder_.path() + "/" + request_name, ignored);
    return trouble;
  };
  written_ = std::async(std::launch::async, std::move(write));
}

std::int64_t Checkpoints::settle() {
  if (!written_.valid()) return last_whole_;
  const auto trouble = written_.get();
  if (trouble.empty()) {
    last_whole_ = window_;
  } else {
    fmt::print(stderr, "warning: no checkpoint at window {}: {}\n", window_, printable(trouble));
  }
  return last_whole_;
}

}  // namespace ricochet::coupler
