#include "common/solver/axial_stress_shares.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace ricochet::solver {
namespace {

double start(const fem::Mesh& mesh, int element) {
  return mesh.position[fem::at(mesh.elements[fem::at(element)][0])][0];
}

std::vector<int> along_bar(const BodyState& state) {
  if (!state.plastic) return {};
  std::vector<int> elements(state.part.mesh.elements.size());
  std::iota(elements.begin(), elements.end(), 0);
  std::sort(elements.begin(), elements.end(),
            [&](int x, int y) { return start(state.part.mesh, x) < start(state.part.mesh, y); });
  return elements;
}

/// A displacement whose strain is the plastic one.
Eigen::VectorXd plastic_displacement(const BodyState& state, const std::vector<int>& along) {
  const auto& mesh = state.part.mesh;
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(state.part.dofs());
  for (const int element : along) {
    const auto& bar = mesh.elements[fem::at(element)];
    const double length_m = mesh.position[fem::at(bar[1])][0] - mesh.position[fem::at(bar[0])][0];
    moved[bar[1]] = moved[bar[0]] + length_m * state.plastic->strain[element];
  }
  return moved;
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
  const fem::SparseMatrix all = fem::axial_stress_shares(state.part, layers);
  std::vector<int> own;
  for (int layer = 0; layer < layers.size(); ++layer) {
    const auto i = static_cast<std::size_t>(layer);
    if (volume[i] == 0.0) continue;
    own.push_back(layer);
    columns_.push_back(
        fmt::format("{}/{:.9g}/{:.9g}/{:.9g}", body.name, layers.border[i], layers.border[i + 1], volume[i]));
  }
  fem::SparseMatrix shares(static_cast<Eigen::Index>(own.size()), all.cols());
  for (std::size_t row = 0; row < own.size(); ++row) {
    shares.startVec(static_cast<Eigen::Index>(row));
    for (fem::SparseMatrix::InnerIterator it(all, own[row]); it; ++it) {
      shares.insertBack(static_cast<Eigen::Index>(row), it.col()) = it.value();
    }
  }
  shares.finalize();
  bodies_.push_back({shares, {}, along_bar(state)});
}

void AxialStressShares::append(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    auto& body = bodies_[b];
    require_finite(states[b], states[b].u, window);
    body.stress.noalias() = body.shares * states[b].u;
    if (!body.along.empty()) body.stress -= body.shares * plastic_displacement(states[b], body.along);
    row.insert(row.end(), body.stress.begin(), body.stress.end());
  }
}

}  // namespace ricochet::solver
