#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.hpp"
#include "common/scene/variant.hpp"

namespace ricochet::coupler {

/// Numbers of a run by the names of its quantities, which end in their units.
using Values = std::map<std::string, double>;

/// The quantities of the run of a scene in a folder that have error bars: peak force, impulse, duration and separation
/// of the contact, with friction "impulse_ratio", its impulse along the tangent over that of the contact, of solids
/// "impulse_ratio_b" along the binormal, "QUANTITY/CONTACT" of each of several, mean interface stress, mean velocity of
/// each body at the end; of one or two bodies that have separated "restitution", their relative velocity along the
/// normal at the end over that of the start, turned round.
[[nodiscard]] Values values_of(const std::string& folder, const scene::Scene& scene);

/// The bar of a quantity is never below this: begin and end of a contact are each known to a window.
[[nodiscard]] double floor_of(const std::string& quantity, double step_s);

/// A run beside the one whose error is estimated.
struct Companion {
  std::string what, error;  ///< error: empty, or why there are no values
  double wall_s = 0.0;
  Values values;

  [[nodiscard]] std::optional<double> value(const std::string& quantity) const;
};

/// Variants of a scene, each computed once in a folder of its own.
class Companions {
 public:
  Companions(const scene::Scene& scene, std::string folder) : scene_(scene), folder_(std::move(folder)) {}

  /// Those that failed are named, too.
  Companion compute(const std::string& what, const std::vector<scene::Override>& changes);
  [[nodiscard]] const std::vector<Companion>& all() const { return all_; }

 private:
  const scene::Scene& scene_;
  std::string folder_;
  std::vector<Companion> all_;
};

/// `times` as many elements along each coordinate, rounded down, which suits a step that is longer in proportion.
/// Empty: a mesh of Gmsh.
[[nodiscard]] std::optional<std::vector<scene::Override>> with_elements(const scene::Scene& scene, double times);

[[nodiscard]] std::vector<scene::Override> with(std::vector<scene::Override> changes,
                                                const std::vector<scene::Override>& more);

/// Refuses, by name, scenes whose companions cannot be run: with bodies or participants that are programs of somebody
/// else's, or started by hand, and with `time.changes`. `asked`: by which word of the command line. ConfigError.
void require_companions(const scene::Scene& scene, const std::string& asked);

}  // namespace ricochet::coupler
