#include "explicit_solver/ranks/rank.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"
#include "common/body/small_steps.hpp"
#include "common/fem/hanging_nodes.hpp"
#include "explicit_solver/local_force.hpp"
#include "explicit_solver/material_force.hpp"

namespace ricochet::explicit_solver {

using fem::at;
using solver::BodyState;

namespace {

/// A number of the whole part's nodes to each of this rank's.
std::vector<int> local_to_whole(const SharedPart& shared, const BodyState& state) {
  std::vector<int> whole;
  for (const int node : state.part.body_node) {
    const auto found = std::lower_bound(shared.nodes.begin(), shared.nodes.end(), node);
    whole.push_back(static_cast<int>(found - shared.nodes.begin()));
  }
  return whole;
}

/// Blocks of the share that are not another rank's.
std::vector<int> own_blocks(const BodyState& state) {
  std::vector<int> blocks;
  for (int node = 0; node < state.part.nodes(); node += block_nodes) {
    if (state.own[at(node)]) blocks.push_back(node / block_nodes);
  }
  return blocks;
}

}  // namespace

/// One part's share, as solver::OtherRanks is asked of it.
class RankShare::Neighbours final : public solver::OtherRanks {
 public:
  Neighbours(const SharedPart& shared, const BodyState& state, Communicator& communicator)
      : communicator_(communicator),
        anything_booked_(shared.booked > 0),
        slides_(shared.slides),
        own_blocks_(own_blocks(state)),
        booked_(booked(shared, state)) {
    find_messages(shared, state);
  }

  void send(const Eigen::VectorXd& u) override {
    for (std::size_t m = 0; m < out_.size(); ++m) {
      for (std::size_t i = 0; i < out_dofs_[m].size(); ++i) out_[m].values[i] = u[out_dofs_[m][i]];
    }
    communicator_.start(out_, in_);
  }
  void receive(Eigen::VectorXd& u) override {
    communicator_.finish();
    for (std::size_t m = 0; m < in_.size(); ++m) {
      for (std::size_t i = 0; i < in_dofs_[m].size(); ++i) u[in_dofs_[m][i]] = in_[m].values[i];
    }
  }
  void collect_moments(const BodyState& state) override {
    if (!slides_) return;
    std::array<double, solver::Moments::numbers> sums{};
    sum_on_first(
        solver::Moments::numbers,
        [&](int block, double* numbers) {
          solver::Moments of_block = solver::block_moments(state, 0.0, block);
          if (state.frame) of_block.turned_kg_m2 = solver::block_turn(state, state.frame->whole().centre_m, 0.0, block);
          of_block.write(numbers);
        },
        sums.data());
    moments_ = solver::Moments::from(sums.data());
  }
  void sum(int numbers, const OfBlock& of_block, double* sums) override {
    sum_on_first(numbers, of_block, sums);
    communicator_.broadcast(sums, static_cast<int>(sizeof(double)) * numbers);
  }
  [[nodiscard]] const solver::Moments& moments() const override { return moments_; }
  bool anywhere(bool here) override { return communicator_.any(here); }

  void book(const std::function<double(int)>& force, const std::function<double(int)>& moved,
            const std::function<Eigen::Vector3d(int)>& place, const Book& book) override {
    if (!anything_booked_) return;
    own_.clear();
    for (const int dof : booked_) {
      own_.push_back(force(dof));
      own_.push_back(moved(dof));
      const Eigen::Vector3d at = place(dof);
      own_.insert(own_.end(), at.data(), at.data() + 3);
    }
    communicator_.gather(own_, counts_, all_);
    for (const auto& entry : entries_) {
      const double* told = &all_[entry.place];
      book(told[0], told[1], entry.component, Eigen::Vector3d(told + 2));
    }
  }

  /// On the first rank: where each degree of freedom that is booked of the whole part comes in, and each block.
  void book_for(const BodyState& whole, const SharedPart& shared) {
    rank_of_block_ = shared.rank_of_block;
    const int components = fem::components(whole.part.mesh.model);
    const auto dofs = whole.booked();
    counts_.assign(at(communicator_.count()), 0);
    for (const int dof : dofs) counts_[at(shared.rank_of(dof / components))] += of_booked;
    auto next = begins(counts_);
    entries_.clear();
    for (const int dof : dofs) {
      std::size_t& place = next[at(shared.rank_of(dof / components))];
      entries_.push_back({place, dof % components});
      place += of_booked;
    }
  }

 private:
  struct Entry {
    std::size_t place;
    int component;
  };
  static constexpr int of_booked = 5;  ///< told of a degree of freedom that is booked

  /// Zero on the others.
  void sum_on_first(int numbers, const OfBlock& of_block, double* sums) {
    own_.resize(own_blocks_.size() * at(numbers));
    for (std::size_t i = 0; i < own_blocks_.size(); ++i) of_block(own_blocks_[i], &own_[i * at(numbers)]);
    std::fill_n(sums, numbers, 0.0);
    std::vector<int> counts(communicator_.rank() == 0 ? at(communicator_.count()) : 0, 0);
    for (const int rank : rank_of_block_) counts[at(rank)] += numbers;
    communicator_.gather(own_, counts, all_);
    auto next = begins(counts);
    for (const int rank : rank_of_block_) {
      for (int i = 0; i < numbers; ++i) sums[i] += all_[next[at(rank)] + at(i)];
      next[at(rank)] += at(numbers);
    }
  }

  /// Where the numbers of each rank begin.
  static std::vector<std::size_t> begins(const std::vector<int>& counts) {
    std::vector<std::size_t> begin(counts.size(), 0);
    for (std::size_t rank = 1; rank < counts.size(); ++rank) begin[rank] = begin[rank - 1] + at(counts[rank - 1]);
    return begin;
  }

  /// Own degrees of freedom at which something acts, in the order of the whole part.
  static std::vector<int> booked(const SharedPart& shared, const BodyState& state) {
    if (!shared.loaded) return state.booked();
    const int components = fem::components(state.part.mesh.model);
    std::vector<int> dofs;
    for (int dof = 0; dof < state.part.dofs(); ++dof) {
      if (state.own[at(dof / components)]) dofs.push_back(dof);
    }
    return dofs;
  }

  /// Both ends of a message list its nodes in ascending order of the whole part.
  void find_messages(const SharedPart& shared, const BodyState& state) {
    const auto whole = local_to_whole(shared, state);
    std::map<int, std::set<int>> out, in;  // per rank, local nodes
    const auto hangs = [&](int node) { return fem::hanging_at(state.part.mesh, node) != nullptr; };
    for (const auto& element : state.part.mesh.elements) {
      const auto nodes = moved_by(state.part.mesh, element);
      for (const int here : nodes) {
        if (!state.own[at(here)]) continue;
        for (const int there : nodes) {
          if (state.own[at(there)]) continue;
          const int rank = shared.rank_of(whole[at(there)]);
          if (!hangs(here)) out[rank].insert(here);
          if (!hangs(there)) in[rank].insert(there);
        }
      }
    }
    std::erase_if(out, [](const auto& message) { return message.second.empty(); });
    std::erase_if(in, [](const auto& message) { return message.second.empty(); });
    const int components = fem::components(state.part.mesh.model);
    const auto list = [&](const std::map<int, std::set<int>>& nodes, std::vector<Communicator::Message>& messages,
                          std::vector<std::vector<int>>& dofs) {
      for (const auto& [rank, of_rank] : nodes) {
        auto& own = dofs.emplace_back();
        for (const int node : of_rank) {
          for (int c = 0; c < components; ++c) own.push_back(node * components + c);
        }
        messages.push_back({rank, std::vector<double>(own.size())});
      }
    };
    list(out, out_, out_dofs_);
    list(in, in_, in_dofs_);
  }

  Communicator& communicator_;
  bool anything_booked_, slides_;
  std::vector<int> own_blocks_, booked_;
  std::vector<Communicator::Message> out_, in_;
  std::vector<std::vector<int>> out_dofs_, in_dofs_;  ///< per message
  std::vector<double> own_, all_;
  // on the first rank
  std::vector<int> counts_, rank_of_block_;
  std::vector<Entry> entries_;
  solver::Moments moments_;
};

RankShare::RankShare(const scene::Problem& problem, const scene::ParticipantSpec& participant,
                     const std::vector<SharedPart>& shared, participant::Drive driven_by, Communicator& communicator) {
  for (const auto& part : shared) {
    auto& state = states_.emplace_back(
        solver::initial_state(problem, part_of_rank(problem, participant, part, communicator.rank()), participant.role,
                              driven_by == participant::Drive::force));
    const int components = fem::components(state.part.mesh.model);
    auto& dofs = own_dofs_.emplace_back();
    for (int dof = 0; dof < state.part.dofs(); ++dof) {
      if (state.own[at(dof / components)]) dofs.push_back(dof);
    }
    own_blocks_.push_back(own_blocks(state));
    neighbours_.push_back(std::make_shared<Neighbours>(part, state, communicator));
    state.others = neighbours_.back().get();
    if (part.frame) state.frame = std::make_shared<solver::PartFrame>(state.part, *part.frame, *state.others);
  }
  solver::compute_with_threads(problem.scene, participant, states_);
}

void RankShare::book_for(const std::vector<BodyState>& whole, const std::vector<SharedPart>& shared) {
  for (std::size_t b = 0; b < whole.size(); ++b) neighbours_[b]->book_for(whole[b], shared[b]);
}

std::vector<double> RankShare::motion() const {
  std::vector<double> values;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const auto& state = states_[b];
    for (const auto* vector : {&state.u, &state.v, &state.a}) {
      for (const int dof : own_dofs_[b]) values.push_back((*vector)[dof]);
    }
    if (!state.plastic) continue;
    const auto& elements = state.part.mesh.elements;
    for (std::size_t e = 0; e < elements.size(); ++e) {
      if (state.own[at(elements[e][0])]) state.plastic->append_element(static_cast<int>(e), values);
    }
  }
  return values;
}

std::vector<double> RankShare::sums(const Stepping& stepping) const {
  std::vector<double> values;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    const BodyState& state = states_[b];
    const auto* const plastic = state.plastic.get();
    if (state.frame) static_cast<void>(state.frame->fit(state.u));  // a trial may have been fitted since
    const Eigen::Matrix3d rotation = state.rotation();
    Eigen::VectorXd in_frame;
    const Eigen::VectorXd& strains = state.straining(in_frame);
    for (const int block : own_blocks_[b]) {
      BlockSums sums = block_sums(state, stepping.internal(b), block);
      if (state.frame) sums.strain_j = state.frame->work_of(rotation, strains, stepping.internal(b), block);
      if (plastic != nullptr) {
        sums.beyond_j = plastic->stored_beyond_j(strains, block, fem::components(state.part.mesh.model));
        sums.plastic_work_j = plastic->work_j[block];
      }
      const auto numbers = sums.as_numbers();
      values.insert(values.end(), numbers.begin(), numbers.end());
    }
    if (plastic != nullptr) values.insert(values.end(), {plastic->largest, plastic->hottest_k});
  }
  return values;
}

void follow(const scene::Problem& problem, const std::string& participant, const std::string& said,
            Communicator& communicator) {
  const auto& spec = problem.scene.participant(participant);
  Beginning beginning;
  Archive in(said, "what the first rank said");
  in(beginning);
  in.end();
  RankShare share(problem, spec, beginning.shared, beginning.setup.driven_by, communicator);
  const auto make_force = [&](const BodyState& state, const std::vector<int>& driven) {
    return solver::takes_small_steps(problem, state) ? local_force(state, driven, {}) : material_force(state, driven);
  };
  Stepping stepping(share.states(), beginning.setup, std::nullopt, make_force);
  std::vector<double> none_of_the_rest;
  for (;;) {
    Command command;
    communicator.broadcast(&command, sizeof command);
    switch (command.order) {
      case Order::synchronise:
        stepping.synchronise(command.window, {});
        for (auto& state : share.states()) state.move_hanging();
        break;
      case Order::reconfigure: {
        std::string bytes;
        communicator.broadcast(bytes);
        Archive told(bytes, "the clock that the first rank told");
        told(beginning.setup.clock);
        told.end();
        stepping.reconfigure();
        break;
      }
      case Order::advance: stepping.advance(command.window, {}); break;
      case Order::advance_substep: stepping.advance_substep(command.window, command.substep, {}); break;
      case Order::accept:
        if (stepping.accept(command.window))
          for (auto& state : share.states()) state.move_hanging();
        break;
      case Order::work_ahead: stepping.work_ahead(command.window); break;
      case Order::sums: communicator.gather(share.sums(stepping), {}, none_of_the_rest); break;
      case Order::motion: communicator.gather(share.motion(), {}, none_of_the_rest); break;
      case Order::save: {
        Archive out;
        auto state = stepping.state();
        out.same_size(state);
        static_cast<void>(communicator.gather(out.take()));
        break;
      }
      case Order::restore: {
        const std::string bytes = communicator.scatter({});
        Archive saved(bytes, "the state of a rank of participant '" + participant + "'");
        auto state = stepping.state();
        saved.same_size(state);
        saved.end();
        stepping.restore(state);
        break;
      }
      case Order::end: return;
    }
  }
}

}  // namespace ricochet::explicit_solver
