#include "common/solver/axial_stress_shares.hpp"

#include <fmt/format.h>

namespace ricochet::solver {
namespace {

/// The rows of a matrix, in this order.
fem::SparseMatrix rows_of(const fem::SparseMatrix& all, const std::vector<int>& rows) {
  fem::SparseMatrix taken(static_cast<Eigen::Index>(rows.size()), all.cols());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    taken.startVec(static_cast<Eigen::Index>(row));
    for (fem::SparseMatrix::InnerIterator it(all, rows[row]); it; ++it)
      taken.insertBack(static_cast<Eigen::Index>(row), it.col()) = it.value();
  }
  taken.finalize();
  return taken;
}

/// The stress that plastic strain takes off the axial stress of each element [Pa].
Eigen::VectorXd axial_plastic_stress(const BodyState& state) {
  const int axial = fem::components(state.part.mesh.model) - 1;
  Eigen::VectorXd stress(static_cast<Eigen::Index>(state.part.mesh.elements.size()));
  for (int e = 0; e < stress.size(); ++e) stress[e] = state.plastic->stress_of(e)[axial];
  return stress;
}

}  // namespace

AxialStressShares::AxialStressShares(const scene::Problem& problem, const std::vector<BodyState>& states) {
  if (problem.scene.output.axial_stress_every == 0) return;
  for (const auto& state : states) add_body(problem, state);
}

void AxialStressShares::add_body(const scene::Problem& problem, const BodyState& state) {
  const auto& body = problem.bodies[static_cast<std::size_t>(state.body)];
  const auto layers = fem::axial_layers(body.mesh, body.section, most_layers);
  const auto volume = fem::volume_shares(state.part, layers);
  std::vector<int> own;
  for (int layer = 0; layer < layers.size(); ++layer) {
    const auto i = static_cast<std::size_t>(layer);
    if (volume[i] == 0.0) continue;
    own.push_back(layer);
    columns_.push_back(
        fmt::format("{}/{:.9g}/{:.9g}/{:.9g}", body.name, layers.border[i], layers.border[i + 1], volume[i]));
  }
  auto& added = bodies_.emplace_back(Body{rows_of(fem::axial_stress_shares(state.part, layers), own), {}});
  if (state.plastic) added.element_shares = rows_of(fem::axial_element_shares(state.part, layers), own);
}

void AxialStressShares::append(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    auto& body = bodies_[b];
    require_finite(states[b], states[b].u, window);
    Eigen::VectorXd in_frame;
    body.stress.noalias() = body.shares * states[b].straining(in_frame);
    if (states[b].plastic) body.stress -= body.element_shares * axial_plastic_stress(states[b]);
    row.insert(row.end(), body.stress.begin(), body.stress.end());
  }
}

}  // namespace ricochet::solver
