#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/problem/problem.hpp"

/// Contact as sparse rows over the degrees of freedom of a participant's parts: all that a contact law of either solver
/// knows of a geometry. Normal n from the first surface (A) to the second (B), tangent t =
/// (-n_y, n_x) (scene::tangent_of), of solids the binormal n x t besides.
///   gap     g = g0 + N u,   open when g > 0            (Eq. 11, 17, 18)
///   slip      = T du over a window, of solids with a component along the binormal
/// With N = n . (u_B - u_A) for two nodes that lie opposite, N = -n . u_A against what is rigid, and a node against two
/// of the other side shared by their weights. A contact force r >= 0 acts as N^T r, on B along +n and on A along -n; a
/// friction force as T^T times it. The law that closes a gap at once needs the compliance N M^-1 N^T.
namespace ricochet::solver {

enum class Side : char { a, b };

struct RowEntry {
  int part = 0;
  int dof = 0;  ///< of the part
  double coefficient = 0.0;
  Side side = Side::a;
};

struct ContactRow {
  std::vector<RowEntry> entries;  ///< none twice; coefficients of A are those of minus its motion

  /// N x, with x one vector per part (`of_part(part)[dof]`).
  template <class OfPart>
  [[nodiscard]] double times(const OfPart& of_part) const {
    double sum = 0.0;
    for (const auto& e : entries) sum += e.coefficient * of_part(e.part)[e.dof];
    return sum;
  }
  /// One side's part of it, along the direction of the row for either: times = of(b) - of(a).
  template <class OfPart>
  [[nodiscard]] double of(Side side, const OfPart& of_part) const {
    double sum = 0.0;
    for (const auto& e : entries) {
      if (e.side == side) sum += e.coefficient * of_part(e.part)[e.dof];
    }
    return side == Side::b ? sum : -sum;
  }
  /// x += M^-1 N^T force: what a force does to accelerations, an impulse to velocities.
  template <class OfPart>
  void push(double force, const std::vector<BodyState>& states, const OfPart& of_part) const {
    for (const auto& e : entries) {
      of_part(e.part)[e.dof] += force * e.coefficient * states[static_cast<std::size_t>(e.part)].inverse_mass[e.dof];
    }
  }
  /// N M^-1 N^T [1/kg], and one side's share of it.
  [[nodiscard]] double inverse_mass(const std::vector<BodyState>& states) const;
  [[nodiscard]] double inverse_mass_of(Side side, const std::vector<BodyState>& states) const;

  [[nodiscard]] bool has(Side side) const;
  [[nodiscard]] int part_of(Side side) const;  ///< of the side's first entry; -1 if it has none
};

/// Components along n, t and b = n x t of one place as those of another.
struct Turn {
  bool turned = false;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();

  [[nodiscard]] Eigen::Vector3d operator()(double normal, const Eigen::Vector2d& along) const {
    const Eigen::Vector3d given(normal, along[0], along[1]);
    return turned ? Eigen::Vector3d(matrix * given) : given;
  }
};

/// A place where the surfaces may touch: two nodes that lie opposite, or a node and a plane.
struct Pair {
  ContactRow normal, tangent;  ///< no entries along the tangent in one dimension
  ContactRow binormal{};       ///< of a solid: along n x t; else no entries
  double gap0_m = 0.0;
  double area_m2 = 0.0;
  double friction_coefficient = 0.0;
  std::size_t contact = 0;  ///< index into Problem::contacts
  int node_a = -1;          ///< of the first surface's body mesh
  int patch = 0;            ///< smooth piece of that surface
  /// To the directions of its contact, in which forces are reported, and to those of the momentum balance. About an
  /// axis what normal forces have across it cancels.
  Turn to_contact{}, to_momentum{};

  /// With contact and patch the same for a row that is written anew: that of an edge of the other surface has a patch
  /// of its own, whatever node it meets.
  [[nodiscard]] int own_node() const { return patch < -1 ? -1 : node_a; }
  /// g0 + N u [m]
  template <class OfPart>
  [[nodiscard]] double gap(const OfPart& u_of_part) const {
    return gap0_m + normal.times(u_of_part);
  }
  /// T x, along tangent and binormal.
  template <class OfPart>
  [[nodiscard]] Eigen::Vector2d slip(const OfPart& of_part) const {
    return {tangent.times(of_part), binormal.times(of_part)};
  }
  /// x += M^-1 T^T force.
  template <class OfPart>
  void push_along(const Eigen::Vector2d& force, const std::vector<BodyState>& states, const OfPart& of_part) const {
    tangent.push(force[0], states, of_part);
    binormal.push(force[1], states, of_part);
  }
  /// The diagonal of T M^-1 T^T [1/kg], which is all of it unless a support is askew to the pair
  [[nodiscard]] Eigen::Matrix2d inverse_mass_along(const std::vector<BodyState>& states) const;
};

/// The numbering of a part: its nodes as its body numbers them, ascending.
struct PartNodes {
  int body = -1;
  const std::vector<int>* body_node = nullptr;
};

/// The rows of a pair.
[[nodiscard]] Pair pair_of(const scene::Problem& problem, std::size_t contact, const scene::ContactPair& pair,
                           const std::vector<PartNodes>& parts);
/// The rows of a scene's contact pairs (all contact nodes must be among the parts).
[[nodiscard]] std::vector<Pair> contact_rows(const scene::Problem& problem, const std::vector<PartNodes>& parts);
[[nodiscard]] std::vector<Pair> contact_rows(const scene::Problem& problem, const std::vector<BodyState>& states);

/// The impulses that a contact has been given so far, along n, t and b of its own [N s].
struct ContactImpulse {
  Eigen::Vector3d of_normal{0.0, 0.0, 0.0}, of_friction{0.0, 0.0, 0.0};

  void archive(Archive& a) { a(of_normal, of_friction); }
};
using ContactImpulses = std::vector<ContactImpulse>;  ///< per contact

/// Pairs that share nodes are gone through one after the other, again and again, until no impulse or force changes by
/// more than this share of the largest (projected Gauss-Seidel), so often at most.
inline constexpr double settled_share = 1e-13;
inline constexpr int most_sweeps = 1000;

/// The present displacement, for `book_impulse`.
[[nodiscard]] inline auto displacement_at(const std::vector<BodyState>& states) {
  return [&states](int part, int dof) { return states[static_cast<std::size_t>(part)].u[dof]; };
}

/// Books the impulses alone of `book_impulse`: what supports take and a rigid plane gives.
void book_without_moments(const Pair& pair, double normal_n_s, const Eigen::Vector2d& tangential_n_s,
                          std::vector<BodyState>& states, ContactImpulses& impulses);

/// The work of a pair's forces [N] on nodes whose motion is given, which move by `moved_of(part, dof)` [m]: who gives
/// it is booked with that of the other forces there, and does this one's, too.
template <class Displacement>
void book_given_motion(const Pair& pair, double normal_n, const Eigen::Vector2d& tangential_n,
                       const Displacement& moved_of, std::vector<BodyState>& states) {
  const auto give = [&](const ContactRow& row, double force_n) {
    if (force_n == 0.0) return;
    for (const auto& e : row.entries) {
      auto& state = states[static_cast<std::size_t>(e.part)];
      if (!state.free[static_cast<std::size_t>(e.dof)])
        state.totals.energy_external_j -= e.coefficient * force_n * moved_of(e.part, e.dof);
    }
  };
  give(pair.normal, normal_n);
  give(pair.tangent, tangential_n[0]);
  give(pair.binormal, tangential_n[1]);
}

/// Books a pair's impulse to its contact and to the totals of its bodies. The normal impulse `normal_n_s` and the
/// tangential one on B, and the opposite ones on A, change no total momentum of two bodies; what a rigid plane gives A
/// is booked to its totals, with its moment about the origin where `u_of(part, dof)` has the nodes [m]. A support
/// has a force booked that is the one on its node, of the contact, too: that is taken back.
template <class Displacement>
void book_impulse(const Pair& pair, double normal_n_s, const Eigen::Vector2d& tangential_n_s, const Displacement& u_of,
                  std::vector<BodyState>& states, ContactImpulses& impulses) {
  if (normal_n_s == 0.0 && tangential_n_s.isZero(0.0)) return;
  book_without_moments(pair, normal_n_s, tangential_n_s, states, impulses);
  const bool by_plane = !pair.normal.has(Side::b);
  const auto give = [&](const ContactRow& row, double impulse_n_s) {
    if (impulse_n_s == 0.0) return;
    for (const auto& e : row.entries) {
      auto& state = states[static_cast<std::size_t>(e.part)];
      const double times = (by_plane ? 1.0 : 0.0) - (state.free[static_cast<std::size_t>(e.dof)] ? 0.0 : 1.0);
      if (times == 0.0) continue;
      state.give_moment(e.dof, times * e.coefficient * impulse_n_s, [&](int dof) { return u_of(e.part, dof); });
    }
  };
  give(pair.normal, normal_n_s);
  give(pair.tangent, tangential_n_s[0]);
  give(pair.binormal, tangential_n_s[1]);
}

}  // namespace ricochet::solver
