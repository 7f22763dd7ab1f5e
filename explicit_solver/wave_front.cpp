#include "explicit_solver/wave_front.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace ricochet::explicit_solver {

using solver::BodyState;

namespace {

/// Per row: something other than the part's own elements may act on it.
std::vector<bool> acted_on(const BodyState& state, const std::vector<int>& driven) {
  std::vector<bool> rows = state.external.loaded(state.part.dofs());
  const int components = fem::components(state.part.mesh.model);
  for (const int node : driven) {
    for (int c = 0; c < components; ++c) rows[static_cast<std::size_t>(node * components + c)] = true;
  }
  for (const auto& c : state.constrained) {
    if (c.motion.moves()) rows[static_cast<std::size_t>(c.dof)] = true;
  }
  return rows;
}

/// Whether the nodes of a row do not all begin with its own displacement and velocity (a component whose translation
/// does make forces: with zero).
bool starts_uneven(const BodyState& state, int row) {
  const int components = fem::components(state.part.mesh.model), node = row / components;
  for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, row); it; ++it) {
    const int c = static_cast<int>(it.col()) % components, own = node * components + c;
    for (const auto* values : {&state.u, &state.v}) {
      if ((*values)[it.col()] != (state.stiffness.translation_is_free(c) ? (*values)[own] : 0.0)) return true;
    }
  }
  return false;
}

}  // namespace

WaveFront::WaveFront(const BodyState& state, const std::vector<int>& driven)
    : size_(state.part.dofs()), slice_(fem::StiffnessProduct::rows_of_slice(fem::components(state.part.mesh.model))) {
  const int slices = (size_ + slice_ - 1) / slice_;
  set_neighbours(state, slices);
  reach_.assign(static_cast<std::size_t>(slices), Reach::none);
  for (auto* list : {&front_, &next_front_}) list->reserve(static_cast<std::size_t>(slices));
  for (auto* rows : {&rows_, &inner_rows_, &outer_rows_}) rows->reserve(static_cast<std::size_t>(slices));
  const std::vector<bool> acted = acted_on(state, driven);
  for (int row = 0; row < size_; ++row) {
    const int slice = row / slice_;
    if (reach_[static_cast<std::size_t>(slice)] == Reach::reached) continue;
    if (acted[static_cast<std::size_t>(row)] || starts_uneven(state, row)) reach(slice);
  }
  for (int slice = 0; slice < slices; ++slice) {
    if (outer_[static_cast<std::size_t>(slice)]) look_at(slice);
  }
  const auto reached = [this](int slice) { return reach_[static_cast<std::size_t>(slice)] == Reach::reached; };
  next_front_.erase(std::remove_if(next_front_.begin(), next_front_.end(), reached), next_front_.end());
  front_.swap(next_front_);
  collect_rows();
}

void WaveFront::set_neighbours(const BodyState& state, int slices) {
  neighbour_start_.push_back(0);
  outer_.assign(static_cast<std::size_t>(slices), false);
  const int components = fem::components(state.part.mesh.model);
  const auto own = [&](Eigen::Index dof) {
    return state.own.empty() || state.own[static_cast<std::size_t>(dof / components)];
  };
  for (int slice = 0; slice < slices; ++slice) {
    std::set<int> near;
    for (int row = slice * slice_; row < std::min((slice + 1) * slice_, size_); ++row) {
      for (fem::SparseMatrix::InnerIterator it(state.part.stiffness, row); it; ++it) {
        near.insert(static_cast<int>(it.col()) / slice_);
        if (!own(it.col())) outer_[static_cast<std::size_t>(slice)] = true;
      }
    }
    neighbour_.insert(neighbour_.end(), near.begin(), near.end());
    neighbour_start_.push_back(static_cast<int>(neighbour_.size()));
  }
}

/// K is symmetric in structure: the rows that read a slice's displacement are in the slices that it reads.
void WaveFront::reach(int slice) {
  reach_[static_cast<std::size_t>(slice)] = Reach::reached;
  const int end = neighbour_start_[static_cast<std::size_t>(slice) + 1];
  for (int k = neighbour_start_[static_cast<std::size_t>(slice)]; k < end; ++k) {
    look_at(neighbour_[static_cast<std::size_t>(k)]);
  }
}

/// From now on it is computed.
void WaveFront::look_at(int slice) {
  auto& state = reach_[static_cast<std::size_t>(slice)];
  if (state != Reach::none) return;
  state = Reach::next;
  next_front_.push_back(slice);
}

void WaveFront::collect_rows() {
  for (auto* rows : {&rows_, &inner_rows_, &outer_rows_}) rows->clear();
  for (std::size_t slice = 0; slice < reach_.size(); ++slice) {
    if (reach_[slice] == Reach::none) continue;
    const int first = static_cast<int>(slice) * slice_, last = std::min(first + slice_, size_);
    for (auto* rows : {&rows_, outer_[slice] ? &outer_rows_ : &inner_rows_}) {
      if (!rows->empty() && rows->back().last == first) {
        rows->back().last = last;
      } else {
        rows->push_back({first, last});
      }
    }
  }
}

void WaveFront::multiply(const BodyState& state, Eigen::VectorXd& u, Eigen::VectorXd& force) const {
  if (state.others != nullptr) state.others->send(u);
  for (const auto& rows : inner_rows_) state.stiffness.multiply(u, force, rows.first, rows.last);
  if (state.others == nullptr) return;  // then there are no outer rows
  state.others->receive(u);
  for (const auto& rows : outer_rows_) state.stiffness.multiply(u, force, rows.first, rows.last);
}

void WaveFront::grow(const Eigen::VectorXd& force) {
  if (front_.empty()) return;
  const auto at_rest = [&](int slice) {
    const int first = slice * slice_, last = std::min(first + slice_, size_);
    return std::all_of(force.data() + first, force.data() + last, [](double f) { return f == 0.0; });
  };
  next_front_.clear();
  const std::size_t none_reached = front_.size();
  for (const int slice : front_) {
    if (at_rest(slice)) {
      next_front_.push_back(slice);
    } else {
      reach(slice);
    }
  }
  const bool unchanged =
      next_front_.size() == none_reached && std::equal(front_.begin(), front_.end(), next_front_.begin());
  front_.swap(next_front_);
  if (!unchanged) collect_rows();
}

/// A front that is refused leaves the present one as it is.
void WaveFront::archive(Archive& a) {
  auto reach = reach_;
  auto front = front_;
  a.same_size(reach);
  a.any_size(front);
  const auto none = [&](int slice) { return slice < 0 || slice >= static_cast<int>(reach.size()); };
  if (std::any_of(front.begin(), front.end(), none)) a.refuse("the wave front of another part");
  if (!a.reading()) return;
  reach_ = std::move(reach);
  front_ = std::move(front);
  collect_rows();
}

void WaveFront::reach_all() {
  std::fill(reach_.begin(), reach_.end(), Reach::reached);
  front_.clear();
  collect_rows();
}

}  // namespace ricochet::explicit_solver
