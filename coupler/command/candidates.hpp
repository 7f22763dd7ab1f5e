#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/cost/predicted_cost.hpp"
#include "coupler/command/method_choice.hpp"

namespace ricochet::coupler {

/// Pilots have elements and step of 2, 4 and that many times the length.
inline constexpr int coarsest_pilot = 8;
[[nodiscard]] std::string with_times(int factor);
/// The first line of an error without the place in the scene file, or the arguments of --set, that were written for it.
[[nodiscard]] std::string reason_of(const std::string& error);

/// Proposals that may be chosen. To predict a cost takes the mesh and its partition. On all meshes but one that is done
/// when a proposal's turn comes: until then its cost is estimated from the one of that mesh, in proportion to the
/// elements.
class Candidates {
 public:
  Candidates(const GivenScene& given, const scene::Problem& problem, const Freedom& freedom);

  /// Takes out the one of least predicted cost; empty: none is left that runs.
  std::optional<Proposal> take_next();
  /// Those whose turn did not come, refused ones last, without those whose cost is but estimated.
  std::vector<Proposal> take_rest();

 private:
  [[nodiscard]] cost::PredictedCost baselines_on(double times) const;
  [[nodiscard]] bool in_own_step(const std::string& protocol) const {
    return protocol == "all_explicit" && !freedom_.explicit_step;
  }
  void add_first_mesh(double times);
  void add_like(const Proposal& first, double times);
  void add(Proposal proposal);
  /// Predicts what it costs, in the step of its own mesh; says why it is refused.
  void settle(Proposal& proposal) const;

  const GivenScene& given_;
  const scene::Problem& problem_;
  const Freedom& freedom_;
  cost::MachineSpeed speed_;
  std::vector<Proposal> all_{};
};

}  // namespace ricochet::coupler
