#include "explicit_solver/ranks/rank.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "common/base/archive.hpp"
#include "common/base/error.hpp"

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
    own_.clear();
    for (const int block : own_blocks_) {
      const solver::Moments of_block = solver::block_moments(state, 0.0, block);
      for (const auto* vector : {&of_block.moved_kg_m, &of_block.mass_kg})
        own_.insert(own_.end(), vector->data(), vector->data() + 3);
    }
    communicator_.gather(own_, moment_counts_, all_);
    moments_ = {};
    for (const std::size_t place : moment_places_)
      moments_.add({Eigen::Vector3d(&all_[place]), Eigen::Vector3d(&all_[place + 3])});
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
    moment_counts_.assign(at(communicator_.count()), 0);
    for (const int rank : shared.rank_of_block) moment_counts_[at(rank)] += 6;
    auto next = begins(moment_counts_);
    moment_places_.clear();
    for (const int rank : shared.rank_of_block) {
      moment_places_.push_back(next[at(rank)]);
      next[at(rank)] += 6;
    }
    const int components = fem::components(whole.part.mesh.model);
    const auto dofs = whole.booked();
    counts_.assign(at(communicator_.count()), 0);
    for (const int dof : dofs) counts_[at(shared.rank_of(dof / components))] += numbers;
    next = begins(counts_);
    entries_.clear();
    for (const int dof : dofs) {
      std::size_t& place = next[at(shared.rank_of(dof / components))];
      entries_.push_back({place, dof % components});
      place += numbers;
    }
  }

 private:
  struct Entry {
    std::size_t place;
    int component;
  };
  static constexpr int numbers = 5;  ///< told of a degree of freedom that is booked

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
    for (const auto& element : state.part.mesh.elements) {
      for (const int here : element) {
        if (!state.own[at(here)]) continue;
        for (const int there : element) {
          if (state.own[at(there)]) continue;
          const int rank = shared.rank_of(whole[at(there)]);
          out[rank].insert(here);
          in[rank].insert(there);
        }
      }
    }
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
  std::vector<int> counts_, moment_counts_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> moment_places_;  ///< per block of the whole part
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
  }
  return values;
}

std::vector<double> RankShare::sums(const Stepping& stepping) const {
  std::vector<double> values;
  for (std::size_t b = 0; b < states_.size(); ++b) {
    for (const int block : own_blocks_[b]) {
      const auto numbers = block_sums(states_[b], stepping.internal(b), block).as_numbers();
      values.insert(values.end(), numbers.begin(), numbers.end());
    }
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
  Stepping stepping(share.states(), beginning.setup, std::nullopt);
  std::vector<double> none_of_the_rest;
  for (;;) {
    Command command;
    communicator.broadcast(&command, sizeof command);
    switch (command.order) {
      case Order::synchronise: stepping.synchronise(command.window, {}); break;
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
      case Order::accept: stepping.accept(command.window); break;
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
