#pragma once

#include <string>

#include "common/contact/contact_surface.hpp"
#include "tests/support/blocks.hpp"

namespace ricochet::test {

/// Blocks and their contact: nine pairs of nodes, n = +z, t = x, n x t = y.
struct ContactBlocks : Blocks {
  solver::ContactSurface surface;

  explicit ContactBlocks(const std::string& protocol, const std::string& contact_keys = "",
                         const std::string& body_keys = "")
      : Blocks(protocol, contact_keys, body_keys), surface(problem, states) {}

  /// Every pair takes a share of its neighbour's row, so that they share nodes.
  void share_nodes() {
    const auto pairs = surface.pairs;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto& other = pairs[(i + 1) % pairs.size()];
      for (const auto row : {&solver::Pair::normal, &solver::Pair::tangent, &solver::Pair::binormal}) {
        auto& entries = (surface.pairs[i].*row).entries;
        for (auto& e : entries) e.coefficient *= 0.75;
        for (auto e : (other.*row).entries) {
          e.coefficient *= 0.25;
          entries.push_back(e);
        }
      }
    }
  }
};

}  // namespace ricochet::test
