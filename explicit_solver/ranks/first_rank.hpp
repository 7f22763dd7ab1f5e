#pragma once

#include <memory>
#include <string>
#include <vector>

#include "explicit_solver/ranks.hpp"
#include "explicit_solver/ranks/rank.hpp"

namespace ricochet::explicit_solver {

/// The ranks as the first one sees them, by a communicator.
class FirstRank final : public Ranks {
 public:
  explicit FirstRank(Communicator& communicator) : communicator_(communicator) {}

  std::vector<solver::BodyState>& begin(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                                        const participant::Setup& setup,
                                        std::vector<solver::BodyState>& whole) override;
  fem::LocalSteps local_steps(std::size_t part) override;
  void tell(Order order, std::int64_t window = 0, int substep = 0) override;
  void reconfigure(WindowClock clock) override;
  void take_totals(const Stepping& own, double dt, std::vector<solver::BodyState>& whole) override;
  void take_motion(std::vector<solver::BodyState>& whole) override;
  std::vector<std::string> save() override;
  void restore(const std::vector<std::string>& saved) override;
  /// Whether the others wait for orders; whether they have been given what to begin with.
  [[nodiscard]] bool going_on() const { return going_on_; }
  [[nodiscard]] bool begun() const { return share_ != nullptr; }

 private:
  Communicator& communicator_;
  std::vector<SharedPart> shared_;
  std::vector<fem::LocalSteps> steps_;  ///< per whole part, until its share has them
  std::unique_ptr<RankShare> share_;
  /// Where the others' numbers go: per rank and part its nodes and blocks of the whole part and, if that yields, the
  /// elements that it tells of; so many numbers a rank.
  std::vector<std::vector<std::vector<int>>> nodes_, blocks_, elements_;
  std::vector<int> motion_counts_, sum_counts_;
  std::vector<double> all_;
  bool going_on_ = false;
};

}  // namespace ricochet::explicit_solver
