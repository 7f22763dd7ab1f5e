#include "explicit_solver/ranks/first_rank.hpp"

#include <algorithm>
#include <utility>

#include "common/body/small_steps.hpp"
#include "common/solver/describe.hpp"

namespace ricochet::explicit_solver {

using fem::at;
using solver::BodyState;

namespace {
/// PlasticState::largest and hottest_k, that each rank tells with its sums.
constexpr int maxima_of_part = 2;
}  // namespace

std::vector<BodyState>& FirstRank::begin(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                                         const participant::Setup& setup, std::vector<BodyState>& whole) {
  // A trial's correction reaches a layer less than there are substeps; the link's motion, one.
  const int layers = setup.driven_by == participant::Drive::force ? std::max(1, setup.substeps - 1) : 1;
  for (const BodyState& state : whole) steps_.push_back(solver::local_steps(problem, state, setup.clock.size_s()));
  shared_ = share_out(problem, whole, steps_, layers, communicator_.count());
  Archive out;
  Beginning beginning{setup, shared_};
  out(beginning);
  std::string bytes = out.take();
  going_on_ = true;
  communicator_.broadcast(bytes);
  share_ = std::make_unique<RankShare>(problem, participant, shared_, setup.driven_by, communicator_);
  if (setup.driven_by == participant::Drive::force)
    solver::take_interface_mass(setup.interface_mass_kg, share_->states());
  share_->book_for(whole, shared_);
  nodes_.assign(at(communicator_.count()), std::vector<std::vector<int>>(whole.size()));
  blocks_ = elements_ = nodes_;
  motion_counts_.assign(nodes_.size(), 0);
  sum_counts_ = motion_counts_;
  for (std::size_t b = 0; b < whole.size(); ++b) {
    const int components = fem::components(whole[b].part.mesh.model);
    for (int node = 0; node < whole[b].part.nodes(); ++node) {
      const auto rank = at(shared_[b].rank_of(node));
      nodes_[rank][b].push_back(node);
      motion_counts_[rank] += 3 * components;
    }
    if (whole[b].plastic) {
      for (int e = 0; e < static_cast<int>(whole[b].part.mesh.elements.size()); ++e) {
        const auto rank = at(shared_[b].rank_of(whole[b].part.mesh.elements[at(e)][0]));  // of its first node
        elements_[rank][b].push_back(e);
        motion_counts_[rank] += whole[b].plastic->numbers_of_element();
      }
      for (int& count : sum_counts_) count += maxima_of_part;
    }
    for (int block = 0; block < blocks_of(whole[b].part.nodes()); ++block) {
      const auto rank = at(shared_[b].rank_of_block[at(block)]);
      blocks_[rank][b].push_back(block);
      sum_counts_[rank] += BlockSums::numbers;
    }
    whole[b].part.stiffness = fem::SparseMatrix();
    whole[b].stiffness = {};
  }
  return share_->states();
}

fem::LocalSteps FirstRank::local_steps(std::size_t part) {
  const auto& own = share_->states()[part].part.body_node;
  std::vector<int> place;
  for (const int node : shared_[part].nodes) {
    const auto found = std::lower_bound(own.begin(), own.end(), node);
    place.push_back(found != own.end() && *found == node ? static_cast<int>(found - own.begin()) : -1);
  }
  fem::LocalSteps steps = std::move(steps_[part]);
  steps.renumber(place, static_cast<int>(own.size()));
  return steps;
}

void FirstRank::tell(Order order, std::int64_t window, int substep) {
  Command command{window, substep, order};
  going_on_ = order != Order::end;
  communicator_.broadcast(&command, sizeof command);
}

void FirstRank::reconfigure(WindowClock clock) {
  tell(Order::reconfigure);
  Archive out;
  out(clock);
  std::string bytes = out.take();
  communicator_.broadcast(bytes);
}

void FirstRank::take_totals(const Stepping& own, double dt, std::vector<BodyState>& whole) {
  tell(Order::sums);
  communicator_.gather(share_->sums(own), sum_counts_, all_);
  std::vector<std::vector<BlockSums>> sums;
  for (const auto& state : whole) {
    sums.emplace_back(at(blocks_of(state.part.nodes())));
    if (state.plastic) state.plastic->largest = state.plastic->hottest_k = 0.0;
  }
  std::size_t next = 0;
  for (const auto& of_rank : blocks_) {
    for (std::size_t b = 0; b < whole.size(); ++b) {
      for (const int block : of_rank[b]) {
        sums[b][at(block)] = BlockSums::from_numbers(&all_[next]);
        next += BlockSums::numbers;
      }
      if (!whole[b].plastic) continue;
      auto& plastic = *whole[b].plastic;
      for (const int block : of_rank[b]) plastic.work_j[block] = sums[b][at(block)].plastic_work_j;
      plastic.largest = std::max(plastic.largest, all_[next]);
      plastic.hottest_k = std::max(plastic.hottest_k, all_[next + 1]);
      next += maxima_of_part;
    }
  }
  for (std::size_t b = 0; b < whole.size(); ++b) {
    const double mass_kg = whole[b].totals.mass_kg;
    whole[b].totals = own.states()[b].totals;  // what is booked
    whole[b].totals.mass_kg = mass_kg;
    BlockSums sum;
    for (const auto& block : sums[b]) sum.add(block);
    set_totals(sum, dt, whole[b]);
    whole[b].totals.energy_strain_j += sum.beyond_j;
  }
}

void FirstRank::take_motion(std::vector<BodyState>& whole) {
  tell(Order::motion);
  communicator_.gather(share_->motion(), motion_counts_, all_);
  const double* next = all_.data();
  for (std::size_t rank = 0; rank < nodes_.size(); ++rank) {
    for (std::size_t b = 0; b < whole.size(); ++b) {
      auto& state = whole[b];
      const int components = fem::components(state.part.mesh.model);
      for (auto* vector : {&state.u, &state.v, &state.a}) {
        for (const int node : nodes_[rank][b]) {
          for (int c = 0; c < components; ++c) (*vector)[node * components + c] = *next++;
        }
      }
      for (const int e : elements_[rank][b]) next = state.plastic->take_element(e, next);
    }
  }
}

std::vector<std::string> FirstRank::save() {
  tell(Order::save);
  return communicator_.gather(std::string());
}

void FirstRank::restore(const std::vector<std::string>& saved) {
  tell(Order::restore);
  static_cast<void>(communicator_.scatter(saved));
}

}  // namespace ricochet::explicit_solver
