#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include "common/base/error.hpp"

namespace ricochet::fem::sample {

/// A file of this process alone: ctest runs tests side by side.
inline std::string temporary_path(const std::string& name) {
  return testing::TempDir() + "fem_" + std::to_string(getpid()) + "_" + name;
}

inline std::string file_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The text of the ConfigError that an action throws.
inline std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no ConfigError";
}

}  // namespace ricochet::fem::sample
