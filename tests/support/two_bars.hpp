#pragma once

#include <string>

#include "tests/support/run.hpp"

namespace ricochet::test {

/// Two equal bars (A1) with 20 times `finer` elements each. Exact: a force between them for a while, full rebound.
inline std::string bars_of(int finer) {
  std::string text = config_text("two_bars");
  for (int body = 0; body < 2; ++body)
    text = replaced(text, "elements = 20 ", "elements = " + std::to_string(20 * finer) + "  ");
  return replaced(text, "step_s = 2.226e-6", "step_s = " + std::to_string(2.226e-6 / finer * 1e9) + "e-9");
}
constexpr double bars_force_n = 1.33453e5, bars_contact_s = 98.937e-6;

}  // namespace ricochet::test
