#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/participant/participant.hpp"
#include "common/problem/problem.hpp"
#include "coupler/interface/coupling.hpp"

namespace ricochet::coupler {

/// The answers of a program of somebody else's in the first windows, against the shipped solver, which computes the
/// scene's own elements beside it in this process from the same link input: steps, loads, supports, initial velocities
/// and elements behind the interface show in nothing that is asked before time passes.
///
/// Numbers may differ by 1e-3 of the largest so far. From the first force on it looks until waves have gone through the
/// participant's longest body and back, at most for 1000 windows. Bodies that any participant lists under
/// `differing_bodies` are left out; of an implicit participant, whose bodies meet, all are then.
class FirstWindows {
 public:
  /// For one that is synchronised at the start and whose places and masses agree with the scene's; null: there
  /// is nothing to compare, or nobody can compute it here. `critical_step_s`: what the shipped solver is told.
  [[nodiscard]] static std::unique_ptr<FirstWindows> of(const scene::Problem& problem, const Coupling& coupling,
                                                        const Link& link, double critical_step_s);

  /// After the window that the link has accepted last. Throws ConfigError naming participant, body, node, window, what
  /// was found and what was expected, and what a scene would lack that gives what was found.
  void look();
  /// It has looked far enough.
  [[nodiscard]] bool over() const { return last_window_ && link_.window() >= *last_window_; }

 private:
  using Values = std::vector<double>;
  /// The quantities that are compared of one answer: force, or displacement, velocity and acceleration.
  struct Quantity {
    std::string name, unit;
    double scale;  ///< largest expected so far, and at first what rounding makes
  };
  struct Difference {
    std::size_t quantity = 0, row = 0;  ///< row of the link
    double found = 0.0, expected = 0.0;
  };
  FirstWindows(const scene::Problem& problem, const Coupling& coupling, const Link& link, double critical_step_s);
  void match_rows(const participant::Description& reference);
  void prepare_setup(const Coupling& coupling);
  void start(participant::Participant& solver, participant::LinkOutput& output) const;
  [[nodiscard]] Values in_its_rows(const Values& own) const;
  [[nodiscard]] std::vector<const Values*> found() const;
  /// The first number that is too far off; `scales`: of the quantities, made larger by what is expected.
  [[nodiscard]] std::vector<Difference> differences(const std::vector<Values>& found,
                                                    const participant::LinkOutput& expected,
                                                    std::vector<Quantity>& quantities) const;
  void compare();
  [[noreturn]] void refuse(const Difference& difference);
  [[nodiscard]] std::string cause() const;
  [[nodiscard]] bool explains(const scene::Problem& other) const;

  const scene::Problem& problem_;
  const Link& link_;
  std::unique_ptr<participant::Participant> solver_;
  participant::Setup setup_;
  participant::LinkOutput expected_;
  std::vector<std::ptrdiff_t> row_of_;  ///< per number of the link that of the solver's; -1: it has none
  std::vector<bool> compared_;          ///< per number of the link
  std::vector<Quantity> quantities_;
  std::vector<Values> inputs_;                ///< per window from the start on, of the link, as long as they are few
  std::vector<std::vector<Values>> answers_;  ///< and quantity
  double wave_speed_m_s_ = 0.0;
  std::int64_t look_windows_ = 0;
  std::optional<std::int64_t> last_window_;  ///< since the first force
};

}  // namespace ricochet::coupler
