#pragma once

#include <string>

namespace ricochet::coupler {

/// The settings that a scene has for its protocol; each protocol looks at its own.
struct ProtocolSettings {
  int substeps = 1;  ///< dual protocols: explicit steps in a window
  // Those of fixed_point.
  std::string acceleration = "iqn_ils";
  double relaxation = 0.5;
  double tolerance = 1e-10;
  int max_iterations = 50;
};

}  // namespace ricochet::coupler
