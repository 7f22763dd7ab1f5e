#include "common/contact/pair_compliance.hpp"

#include <algorithm>
#include <utility>

namespace ricochet::solver {

Compliance::Sparse matrix_of_rows(const std::vector<Pair>& pairs, Eigen::Index directions, Eigen::Index columns,
                                  const std::function<int(const RowEntry&)>& column) {
  const auto n = static_cast<Eigen::Index>(pairs.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index row = 0; row < directions * n; ++row) {
    for (const auto& e : row_of(pairs[static_cast<std::size_t>(row % n)], row / n).entries) {
      if (const int at = column(e); at >= 0) entries.emplace_back(static_cast<int>(row), at, e.coefficient);
    }
  }
  Compliance::Sparse rows(directions * n, columns);
  rows.setFromTriplets(entries.begin(), entries.end());
  return rows;
}

Compliance inverse_mass_of(const std::vector<Pair>& pairs, const std::vector<BodyState>& states,
                           Eigen::Index directions) {
  std::vector<std::pair<int, int>> dofs;  // part and number of those that have a row
  for (const auto& pair : pairs)
    for (Eigen::Index d = 0; d < directions; ++d)
      for (const auto& e : row_of(pair, d).entries) dofs.emplace_back(e.part, e.dof);
  std::sort(dofs.begin(), dofs.end());
  dofs.erase(std::unique(dofs.begin(), dofs.end()), dofs.end());
  Eigen::VectorXd inverse(std::ssize(dofs));
  for (Eigen::Index i = 0; i < inverse.size(); ++i) {
    const auto& [part, dof] = dofs[static_cast<std::size_t>(i)];
    inverse[i] = states[static_cast<std::size_t>(part)].inverse_mass[dof];
  }
  const auto column = [&](const RowEntry& e) {
    return static_cast<int>(std::lower_bound(dofs.begin(), dofs.end(), std::pair(e.part, e.dof)) - dofs.begin());
  };
  const Compliance::Sparse rows = matrix_of_rows(pairs, directions, inverse.size(), column);
  const Compliance::Sparse columns = inverse.asDiagonal() * Compliance::Sparse(rows.transpose());
  return Compliance::Sparse(rows * columns);
}

UnitResponses unit_responses(std::vector<std::pair<int, int>> dofs, const std::vector<InternalForce*>& of_part,
                             const std::vector<BodyState>& states) {
  std::sort(dofs.begin(), dofs.end());
  dofs.erase(std::unique(dofs.begin(), dofs.end()), dofs.end());
  UnitResponses responses{std::move(dofs), {}};
  const auto size = std::ssize(responses.dofs);
  responses.matrix.setZero(size, size);
  Eigen::VectorXd force;
  for (Eigen::Index column = 0; column < size; ++column) {
    const auto [part, dof] = responses.dofs[static_cast<std::size_t>(column)];
    const auto& inverse_mass = states[static_cast<std::size_t>(part)].inverse_mass;
    if (!of_part[static_cast<std::size_t>(part)]->spreads(dof)) {
      responses.matrix(column, column) = inverse_mass[dof];
      continue;
    }
    force.setZero(inverse_mass.size());
    force[dof] = 1.0;
    of_part[static_cast<std::size_t>(part)]->spread(force);
    for (Eigen::Index row = 0; row < size; ++row) {
      const auto& [of, number] = responses.dofs[static_cast<std::size_t>(row)];
      if (of == part) responses.matrix(row, column) = force[number] * inverse_mass[number];
    }
  }
  return responses;
}

namespace {

/// R: from the degrees of freedom of the responses in space to those in the frames of the parts.
Compliance::Sparse turn_of(const UnitResponses& responses, const std::vector<Eigen::Matrix3d>& turns,
                           Eigen::Index components) {
  const auto size = std::ssize(responses.dofs);
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto& [part, dof] = responses.dofs[static_cast<std::size_t>(i)];
    const Eigen::Index c = dof % components, first = i - c;
    for (Eigen::Index d = 0; d < components; ++d)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(first + d),
                           turns[static_cast<std::size_t>(part)](c, d));
  }
  Compliance::Sparse turn(size, size);
  turn.setFromTriplets(entries.begin(), entries.end());
  return turn;
}

}  // namespace

Compliance compliance_of(const std::vector<Pair>& pairs, const UnitResponses& responses,
                         const std::vector<Eigen::Matrix3d>& turns, Eigen::Index components, Eigen::Index directions) {
  const auto& dofs = responses.dofs;
  const auto column = [&](const RowEntry& e) {
    return static_cast<int>(std::lower_bound(dofs.begin(), dofs.end(), std::pair(e.part, e.dof)) - dofs.begin());
  };
  Compliance::Sparse rows = matrix_of_rows(pairs, directions, std::ssize(dofs), column);
  if (!turns.empty()) rows = Compliance::Sparse(rows * turn_of(responses, turns, components));
  return Eigen::MatrixXd(rows * responses.matrix * rows.transpose());
}

}  // namespace ricochet::solver
