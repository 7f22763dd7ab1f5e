#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "coupler/processes/given_scene.hpp"

namespace ricochet::coupler {

/// Relative errors that are asked of results, by their names as `error_bar` has them (values_of).
using AskedErrors = std::map<std::string, double>;

/// The settings that a choice may vary.
struct Freedom {
  std::vector<std::string> protocols;      ///< empty: the scene's and the baselines
  std::vector<double> steps_s;             ///< of all but all_explicit
  std::optional<double> largest_step_s{};  ///< no longer one on any mesh; all_explicit in its own step aside
  bool explicit_step = false;              ///< all_explicit, too, takes those steps, and not the longest of its own
  bool with_next = true;                   ///< looks on for the cheapest of another protocol
  bool one_step = false;  ///< the same step on each mesh; elsewhere steps and elements are in proportion
};
/// `ricochet advise --quantity`: any protocol, in steps of 1/2 to 16 times the scene's.
[[nodiscard]] Freedom any_method(const scene::Problem& problem);
/// Table [accuracy]: what the scene leaves open. A largest step has halves of it below.
[[nodiscard]] Freedom open_in_scene(const scene::Problem& problem);

/// One protocol, step and mesh.
struct Proposal {
  std::string protocol;
  double step_s = 0.0, elements_times = 1.0, predicted_s = 0.0;
  bool estimated = false;      ///< predicted_s is, from another mesh
  bool without_pilot = false;  ///< refused since its coarsest pilot's mesh cannot be built
  std::string refused{};       ///< why it cannot be run, or has no bar
  struct Bar {
    double relative = 0.0;
    std::optional<double> order{};
  };
  std::map<std::string, Bar> bars{};  ///< by quantity; empty: no pilot was computed
  [[nodiscard]] bool runs() const { return refused.empty(); }
  [[nodiscard]] bool reaches(const AskedErrors& asked) const;
  /// Keys to change so that `scene` becomes the one to run; `factor`: with elements and step of that many times the
  /// length.
  [[nodiscard]] std::vector<scene::Override> changes(const scene::Scene& scene, int factor = 1) const;
};

struct MethodChoice {
  /// Those tried, in the order of predicted times, then others, refused ones last. Proposals on other meshes that
  /// would cost more are left out.
  std::vector<Proposal> proposals;
  std::optional<std::size_t> best, next;  ///< next: the cheapest by another protocol that reaches the errors
  std::size_t pilots = 0;
  double pilots_s = 0.0;
};

/// Finds the protocol and step, and the mesh of those that the scene allows, that reach the errors in the least
/// predicted time. In the order of their predicted time proposals are computed with elements and step of two, four and
/// eight times the length, in `folder`. The bar of the first of these pilots (error_bar), halved at an observed order
/// of one, is what the proposal is expected to have on its own mesh. `given`: the scene whose problem this is.
[[nodiscard]] MethodChoice choose_method(const GivenScene& given, const scene::Problem& problem,
                                         const AskedErrors& asked, const Freedom& freedom, const std::string& folder);

/// ConfigError where that cannot be asked of the scene: a quantity that it has not, no coarser meshes, programs of
/// somebody else's, or the peak force of a flat impact, whose front overshoots on every mesh. `asked_by`: the command
/// or table.
void require_choice(const scene::Problem& problem, const AskedErrors& asked, const std::string& asked_by);

/// ConfigError that says the least bar of what is farthest from the error asked, and how much finer the elements are to
/// be. `in_scene`: the table [accuracy] asks, not the command.
[[noreturn]] void refuse_unreached(const scene::Problem& problem, const MethodChoice& choice, const AskedErrors& asked,
                                   bool in_scene);

[[nodiscard]] std::string to_table(const MethodChoice& choice, const AskedErrors& asked);
[[nodiscard]] std::string to_csv(const MethodChoice& choice, const AskedErrors& asked);
/// "contact_impulse_n_s within 1 %, ..."
[[nodiscard]] std::string to_text(const AskedErrors& asked);

}  // namespace ricochet::coupler
