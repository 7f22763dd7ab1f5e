#include "common/contact/massless_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/base/error.hpp"
#include "common/fem/element.hpp"

namespace ricochet::solver {
namespace {

/// Nodes that share an edge of an element with a contact node and are none themselves, per contact node of `contact`.
std::vector<std::vector<int>> inward_neighbours(const BodyState& state, const std::vector<int>& contact) {
  std::vector<int> place(static_cast<std::size_t>(state.part.nodes()), -1);
  for (std::size_t i = 0; i < contact.size(); ++i) place[static_cast<std::size_t>(contact[i])] = static_cast<int>(i);
  std::vector<std::vector<int>> inward(contact.size());
  const auto note = [&](int node, int other) {
    const int at = place[static_cast<std::size_t>(node)];
    if (at < 0 || place[static_cast<std::size_t>(other)] >= 0) return;
    auto& found = inward[static_cast<std::size_t>(at)];
    if (std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
  };
  for (const auto& element : state.part.mesh.elements) {
    const auto edges = fem::traits(element.kind).edges;
    for (const auto& [a, b] : edges) note(element[fem::at(a)], element[fem::at(b)]);
    for (const auto& [a, b] : edges) note(element[fem::at(b)], element[fem::at(a)]);
  }
  return inward;
}

[[noreturn]] void refuse(const BodyState& state, int node) {
  const auto& x = state.part.mesh.position[static_cast<std::size_t>(node)];
  throw ConfigError(fmt::format(
      "contact.multiplier_update = \"massless\": the contact node {} of body '{}' at {} has no "
      "neighbour behind the "
      "contact surface among the elements of its participant to take its mass; give it a layer of elements, or use "
      "\"trapezoidal_reset\"",
      state.part.body_node[static_cast<std::size_t>(node)], state.name, fem::place_text(state.part.mesh.model, x)));
}

}  // namespace

MasslessNodes::MasslessNodes(const ContactSurface& surface, std::vector<BodyState>& states)
    : surface_(&surface),
      statics_(states.size()),
      inward_(surface.pairs.size()),
      trial_debt_j_(surface.pairs.size(), 0.0) {
  state_.debt_j = trial_debt_j_;
  move_masses(states);
  factor(states);
}

/// The mass that a degree of freedom has along the normal goes to the same component of the node's neighbours.
void MasslessNodes::move_masses(std::vector<BodyState>& states) {
  const int components = surface_->components;
  for (std::size_t part = 0; part < states.size(); ++part) {
    auto& state = states[part];
    std::vector<std::pair<std::size_t, RowEntry>> entries;  // of pairs
    std::vector<int> contact;                               // nodes, each once
    for (std::size_t i = 0; i < surface_->pairs.size(); ++i) {
      for (const auto& e : surface_->pairs[i].normal.entries) {
        if (e.part != static_cast<int>(part)) continue;
        entries.emplace_back(i, e);
        if (contact.empty() || contact.back() != e.dof / components) contact.push_back(e.dof / components);
      }
    }
    if (contact.empty()) continue;
    auto statics = std::make_unique<Statics>();
    statics->place.assign(static_cast<std::size_t>(state.part.dofs()), -1);
    const auto inward = inward_neighbours(state, contact);
    for (std::size_t k = 0; k < contact.size(); ++k) {
      if (inward[k].empty()) refuse(state, contact[k]);
    }
    std::size_t k = 0;
    for (const auto& [pair, e] : entries) {
      if (contact[k] != e.dof / components) ++k;
      if (!state.free[static_cast<std::size_t>(e.dof)]) continue;
      const double share = 1.0 / static_cast<double>(inward[k].size());
      for (const int other : inward[k]) {
        const int to = other * components + e.dof % components;
        state.mass[to] += share * state.mass[e.dof];
        if (state.free[static_cast<std::size_t>(to)]) state.inverse_mass[to] = 1.0 / state.mass[to];
        inward_[pair].push_back({part, to, share * e.coefficient});
      }
      state.mass[e.dof] = state.inverse_mass[e.dof] = 0.0;
      statics->place[static_cast<std::size_t>(e.dof)] = static_cast<int>(statics->dofs.size());
      statics->dofs.push_back(e.dof);
    }
    if (!statics->dofs.empty()) statics_[part] = std::move(statics);
  }
}

void MasslessNodes::Statics::solve() {
  factor.matrixL().solveInPlace(moved);
  factor.matrixU().solveInPlace(moved);
}

/// Calls f(entry, moved) for the entries of a pair's normal row that are massless.
template <class F>
void MasslessNodes::for_each_massless(const Pair& pair, const F& f) {
  for (const auto& e : pair.normal.entries) {
    auto& statics = statics_[static_cast<std::size_t>(e.part)];
    if (!statics) continue;
    const int at = statics->place[static_cast<std::size_t>(e.dof)];
    if (at >= 0) f(e, statics->moved[at]);
  }
}

/// K_cc of every part, and the root problem of the pairs' normal forces with the compliance N K_cc^-1 N^T.
void MasslessNodes::factor(const std::vector<BodyState>& states) {
  for (std::size_t part = 0; part < states.size(); ++part) {
    if (!statics_[part]) continue;
    auto& statics = *statics_[part];
    const auto size = static_cast<Eigen::Index>(statics.dofs.size());
    std::vector<Eigen::Triplet<double>> entries;
    statics.rows.resize(size, states[part].part.dofs());
    for (int i = 0; i < static_cast<int>(size); ++i) {
      statics.rows.startVec(i);
      for (fem::SparseMatrix::InnerIterator it(states[part].part.stiffness, statics.dofs[static_cast<std::size_t>(i)]);
           it; ++it) {
        statics.rows.insertBack(i, it.col()) = it.value();
        const int column = statics.place[static_cast<std::size_t>(it.col())];
        if (column >= 0) entries.emplace_back(i, column, it.value());
      }
    }
    statics.rows.finalize();
    Eigen::SparseMatrix<double> k(size, size);
    k.setFromTriplets(entries.begin(), entries.end());
    statics.factor.compute(k);
    if (statics.factor.info() != Eigen::Success) {
      throw SolverError(fmt::format("body '{}': the stiffness of its massless contact nodes is not positive definite",
                                    states[part].name));
    }
    statics.moved.setZero(size);
  }
  const auto pairs = static_cast<Eigen::Index>(surface_->pairs.size());
  Eigen::MatrixXd compliance(pairs, pairs);
  for (Eigen::Index j = 0; j < pairs; ++j) {
    for (auto& statics : statics_)
      if (statics) statics->moved.setZero();
    load(Eigen::VectorXd::Unit(pairs, j));
    for (auto& statics : statics_)
      if (statics) statics->solve();
    for (Eigen::Index i = 0; i < pairs; ++i) {
      double gap = 0.0;
      for_each_massless(surface_->pairs[static_cast<std::size_t>(i)],
                        [&](const RowEntry& e, double& moved) { gap += e.coefficient * moved; });
      compliance(i, j) = gap;
    }
  }
  scene::Contact normal_only;
  root_.emplace(normal_only, compliance, std::vector<RootProblem::PairLaw>(surface_->pairs.size()), 1.0);
  state_.last = root_->open();
  gap_free_.setZero(pairs);
}

void MasslessNodes::load(const Eigen::VectorXd& normal_forces) {
  for (std::size_t i = 0; i < surface_->pairs.size(); ++i) {
    const auto& pair = surface_->pairs[i];
    const double force = normal_forces[static_cast<Eigen::Index>(i)];
    if (force == 0.0) continue;
    for_each_massless(pair, [&](const RowEntry& e, double& moved) { moved += e.coefficient * force; });
  }
}

const Eigen::VectorXd& MasslessNodes::settle(const std::vector<BodyState>& states, const ReadOfPart& external,
                                             const OfPart& u) {
  const auto move = [&] {
    for (std::size_t part = 0; part < states.size(); ++part) {
      if (!statics_[part]) continue;
      auto& statics = *statics_[part];
      statics.solve();
      for (std::size_t i = 0; i < statics.dofs.size(); ++i)
        u(part)[statics.dofs[i]] += statics.moved[static_cast<Eigen::Index>(i)];
      statics.moved.setZero();
    }
  };
  for (std::size_t part = 0; part < states.size(); ++part) {
    if (!statics_[part]) continue;
    auto& statics = *statics_[part];
    for (std::size_t i = 0; i < statics.dofs.size(); ++i) {
      double force = external(part)[statics.dofs[i]];
      for (fem::SparseMatrix::InnerIterator it(statics.rows, static_cast<Eigen::Index>(i)); it; ++it)
        force -= it.value() * u(part)[it.col()];
      statics.moved[static_cast<Eigen::Index>(i)] = force;
    }
  }
  move();
  const auto of_part = [&](int part) -> const Eigen::VectorXd& { return u(static_cast<std::size_t>(part)); };
  for (std::size_t i = 0; i < surface_->pairs.size(); ++i) {
    gap_free_[static_cast<Eigen::Index>(i)] = surface_->pairs[i].gap(of_part);
  }
  state_.last = root_->solve(gap_free_, gap_free_, gap_free_, state_.last);
  require_solved(state_.last);
  load(state_.last.force);
  move();
  return state_.last.force;
}

double MasslessNodes::give_back(std::size_t pair, double made_j, double most_n_s, const std::vector<BodyState>& states,
                                const std::function<double*(std::size_t part)>& velocity) {
  double& debt = trial_debt_j_[pair];
  debt = state_.debt_j[pair] + made_j;
  double rate = 0.0, inverse_mass = 0.0;
  for (const auto& share : inward_[pair]) {
    rate += share.of_rate * velocity(share.part)[share.dof];
    inverse_mass += share.of_rate * share.of_rate * states[share.part].inverse_mass[share.dof];
  }
  if (debt == 0.0 || inverse_mass == 0.0 || !(most_n_s > 0.0)) return 0.0;
  // J rate + J^2 inverse_mass / 2 = -debt, the root next to zero; without one, what stops the rate
  const double square = rate * rate - 2.0 * debt * inverse_mass;
  const double after = square > 0.0 ? std::copysign(std::sqrt(square), rate) : 0.0;
  const double impulse = std::clamp((after - rate) / inverse_mass, -most_n_s, most_n_s);
  const double work = impulse * (rate + 0.5 * impulse * inverse_mass);
  for (const auto& share : inward_[pair]) {
    velocity(share.part)[share.dof] += share.of_rate * states[share.part].inverse_mass[share.dof] * impulse;
  }
  debt += work;
  trial_work_j_ += work;
  return impulse;
}

}  // namespace ricochet::solver
