#pragma once

namespace ricochet::coupler {

/// How `fixed_point` chooses the next displacement of the shared nodes.
enum class Acceleration { constant, aitken, iqn_ils };

/// What a scene says to its protocol; each protocol looks at its own.
struct ProtocolSettings {
  int substeps = 1;  ///< dual protocols: explicit steps in a window
  Acceleration acceleration = Acceleration::iqn_ils;
  double relaxation = 0.5;
  double tolerance = 1e-10;
  int max_iterations = 50;
};

}  // namespace ricochet::coupler
