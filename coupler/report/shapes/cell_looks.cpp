#include "coupler/report/shapes/cell_looks.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace ricochet::report {
namespace {

double along(const Place& a, const Place& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Place across(const Place& a, const Place& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Place difference_of(const Place& a, const Place& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

Place unit(const Place& a) {
  const double length = std::sqrt(along(a, a));
  return length > 0.0 ? Place{a[0] / length, a[1] / length, a[2] / length} : Place{};
}

std::size_t corners_of(const std::array<int, 4>& cell) {
  return static_cast<std::size_t>(std::find(cell.begin(), cell.end(), -1) - cell.begin());
}

const Place& corner_of(const std::vector<Place>& places, const std::array<int, 4>& cell, std::size_t corner) {
  return places[static_cast<std::size_t>(cell[corner])];
}

/// Outward of a face of a solid: the product of its diagonals, of a triangle that of two edges.
Place normal_of(const std::vector<Place>& places, const std::array<int, 4>& cell) {
  const bool triangle = cell[3] < 0;
  const auto& first = corner_of(places, cell, 0);
  const auto one = difference_of(corner_of(places, cell, triangle ? 1 : 2), first);
  const auto two = triangle ? difference_of(corner_of(places, cell, 2), first)
                            : difference_of(corner_of(places, cell, 3), corner_of(places, cell, 1));
  return unit(across(one, two));
}

/// One use of an edge, or of a node of a bar, by a cell.
struct EdgeUse {
  int body, low, high;  ///< numbers of its nodes in the body
  std::size_t piece, cell, edge;

  [[nodiscard]] auto key() const { return std::tie(body, low, high); }
};

void hide_inner_faces(const Shapes& shapes, std::vector<std::vector<CellLook>>& looks) {
  std::vector<std::tuple<int, std::array<int, 4>, std::size_t, std::size_t>> faces;
  for (std::size_t p = 0; p < shapes.pieces.size(); ++p) {
    const auto& piece = shapes.pieces[p];
    for (std::size_t c = 0; c < piece.cells.size(); ++c) {
      std::array<int, 4> nodes{-1, -1, -1, -1};
      for (std::size_t i = 0; i < corners_of(piece.cells[c]); ++i)
        nodes[i] = piece.node[static_cast<std::size_t>(piece.cells[c][i])];
      std::sort(nodes.begin(), nodes.end());
      faces.emplace_back(piece.body, nodes, p, c);
    }
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t i = 1; i < faces.size(); ++i) {
    const auto& [body, nodes, piece, cell] = faces[i];
    const auto& [other_body, other_nodes, other_piece, other_cell] = faces[i - 1];
    if (body != other_body || nodes != other_nodes) continue;
    looks[piece][cell].hidden = looks[other_piece][other_cell].hidden = true;
  }
}

std::vector<EdgeUse> edge_uses(const Shapes& shapes, const std::vector<std::vector<CellLook>>& looks) {
  std::vector<EdgeUse> uses;
  for (std::size_t p = 0; p < shapes.pieces.size(); ++p) {
    const auto& piece = shapes.pieces[p];
    for (std::size_t c = 0; c < piece.cells.size(); ++c) {
      if (looks[p][c].hidden) continue;
      const auto& cell = piece.cells[c];
      const std::size_t corners = corners_of(cell);
      const auto node = [&](std::size_t i) { return piece.node[static_cast<std::size_t>(cell[i % corners])]; };
      if (corners == 2) {  // the ends of a strip: its edges 1 and 3
        uses.push_back({piece.body, node(1), node(1), p, c, 1});
        uses.push_back({piece.body, node(0), node(0), p, c, 3});
        continue;
      }
      for (std::size_t i = 0; i < corners; ++i) {
        const int a = node(i), b = node(i + 1);
        uses.push_back({piece.body, std::min(a, b), std::max(a, b), p, c, i});
      }
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tuple(a.key(), a.piece, a.cell) < std::tuple(b.key(), b.piece, b.cell);
  });
  return uses;
}

/// The kind that the cells which share an edge make of it.
EdgeKind kind_of(const Shapes& shapes, const EdgeUse* begin, const EdgeUse* end) {
  const auto& piece = shapes.pieces[begin->piece];
  const auto& cell = piece.cells[begin->cell];
  if (end - begin != 2) {
    const std::size_t corners = corners_of(cell);
    const double radii = corner_of(piece.position, cell, begin->edge % corners)[0] +
                         corner_of(piece.position, cell, (begin->edge + 1) % corners)[0];
    return shapes.model == "axisymmetric" && radii == 0.0 ? EdgeKind::none : EdgeKind::outline;  // the axis is no edge
  }
  if (shapes.model != "solid") return EdgeKind::inner;
  const auto& other = shapes.pieces[begin[1].piece];
  const double cosine = along(normal_of(piece.position, cell), normal_of(other.position, other.cells[begin[1].cell]));
  return cosine < 0.866 ? EdgeKind::outline : EdgeKind::inner;
}

}  // namespace

std::vector<std::vector<CellLook>> cell_looks(const Shapes& shapes) {
  std::vector<std::vector<CellLook>> looks;
  for (const auto& piece : shapes.pieces) looks.emplace_back(piece.cells.size());
  if (shapes.model == "solid") hide_inner_faces(shapes, looks);
  if (shapes.model == "bar") {
    for (auto& piece : looks) {
      for (auto& look : piece) look.edges[0] = look.edges[2] = EdgeKind::outline;
    }
  }
  const auto uses = edge_uses(shapes, looks);
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i;
    while (end < uses.size() && uses[end].key() == uses[i].key()) ++end;
    auto kind = kind_of(shapes, &uses[i], &uses[i] + (end - i));
    if (kind == EdgeKind::inner && shapes.pieces[uses[i].piece].rigid) kind = EdgeKind::none;  // it has no elements
    for (; i < end; ++i) looks[uses[i].piece][uses[i].cell].edges[uses[i].edge] = kind;
  }
  return looks;
}

}  // namespace ricochet::report
