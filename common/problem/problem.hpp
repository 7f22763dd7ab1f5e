#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "common/base/window_clock.hpp"
#include "common/fem/mesh.hpp"
#include "common/fem/part.hpp"
#include "common/fem/rigid_motion.hpp"
#include "common/fem/stiffness_product.hpp"
#include "common/scene/scene.hpp"
#include "common/surface/mortar.hpp"

/// A scene turned into meshes, contact pairs and partitions: what both solvers and `check` start from.
namespace ricochet::scene {

using fem::WeightedNode;

/// A contact node of the surface that carries the rows and what lies opposite.
struct ContactPair {
  int node_a = -1;                ///< of body_a's mesh; of several the one with the largest share
  std::vector<WeightedNode> a{};  ///< of body_a's mesh, where it is not node_a alone: at edges and hanging nodes
  int patch = 0;                  ///< smooth piece of that surface: a node between two has a pair for each
  /// Nodes of the other surface: one at the same place, several where meshes differ, none of what is rigid.
  std::vector<WeightedNode> b;
  Eigen::Vector3d normal{0.0, 0.0, 0.0};  ///< n, out of body a
  double gap0_m = 0.0;                    ///< initial gap >= 0
  double area_m2 = 0.0;                   ///< tributary area: integral of N dA over that surface's faces
  double distance_m = 0.0;                ///< from the axis (first coordinate of node a), for the nose and for output
};

/// Its nodes of body_a.
[[nodiscard]] inline std::vector<WeightedNode> own_nodes(const ContactPair& pair) {
  return pair.a.empty() ? std::vector<WeightedNode>{{pair.node_a, 1.0}} : pair.a;
}

struct ContactGeometry {
  std::string name;  ///< of one of several
  /// Index into Problem::bodies. The rows are those of nodes of body_a, whose surface has the finer mesh; where both
  /// are as fine, of the body that comes first, and of pairs of nodes the one named first. "First" and "second" surface
  /// are those of body_a and body_b here and in all that follows, but where the named ones are spoken of.
  int body_a = -1;
  int body_b = -1;                              ///< -1: what is rigid
  bool round = false;                           ///< that is a sphere or a cylinder
  bool second_named_first = false;              ///< body_a has the surface that the scene names second
  Eigen::Vector3d normal{0.0, 0.0, 0.0};        ///< n, out of body a, of a curved surface its mean; bar: (+-1, 0, 0)
  Eigen::Vector3d named_normal{0.0, 0.0, 0.0};  ///< the same out of the surface named first, as columns have it
  bool matching = false;                        ///< pairs of nodes: every `b` is one node of weight 1, or none
  std::vector<ContactPair> pairs;               ///< sorted by distance
  bool flat = true;                             ///< both surfaces are, and parallel, and none turns
  bool turns = false;                           ///< one of the bodies has large_rotation
  bool reaches_beyond = false;                  ///< one of them does, beyond its surface: it may meet the other there
  double off_faces_m = 0.0;  ///< furthest that smooth surfaces, which contact goes by, are from their faces
  /// By how much the second body is taken to be off its mesh at the start: initial_gap_m along the normal.
  Eigen::Vector3d lifted_m{0.0, 0.0, 0.0};
  /// By how much the second body is off its mesh where the pairs are written: lifted_m; of curved surfaces, and of such
  /// as lie nowhere opposite at the start, where it touches the first, which has touch_normal there.
  Eigen::Vector3d shift_m{0.0, 0.0, 0.0}, touch_normal{0.0, 0.0, 0.0};
  /// From this the pairs of bodies that may slide along each other are found anew. Then all nodes of both surfaces,
  /// but for hanging ones, are contact nodes, else those of the pairs.
  std::shared_ptr<const surface::ContactMesh> sliding;
  std::array<std::vector<int>, 2> sliding_nodes{};  ///< then of body_a and body_b, ascending, without hanging ones
  Eigen::Vector3d middle_m{0.0, 0.0, 0.0};          ///< of a sphere or a cylinder, its initial gap in it
};

/// The direction along the surface that momentum and friction are looked at in: t = (-n_y, n_x, 0), n turned round to
/// the left, of length 1; of a solid's normal within 45 degrees of the z axis the part of x across n, which round-off
/// does not turn. A solid has the binormal n x t besides.
[[nodiscard]] inline Eigen::Vector3d tangent_of(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d turned(-normal[1], normal[0], 0.0);
  if (normal[2] == 0.0) return turned;
  if (normal[2] * normal[2] < 0.5 * normal.squaredNorm()) return turned.normalized();
  return (Eigen::Vector3d::UnitX() - normal[0] / normal.squaredNorm() * normal).normalized();
}

struct BodyProblem {
  std::string name;
  fem::Section section;
  fem::Material material;              ///< of elements to which the mesh gives no other: fem::material_of
  fem::Mesh mesh;                      ///< the whole body
  std::vector<double> density_factor;  ///< per element, by mass scaling (mass_scaling.hpp); empty: all 1
  std::vector<bool> implicit_element;  ///< per element; those at joined nodes are
  /// Per element: explicit, and may take several steps in a window (fem::LocalSteps); empty: none.
  std::vector<bool> small_steps;
  std::vector<bool> implicit_node;  ///< per node: integrated by the implicit participant
  std::vector<bool> joined_node;    ///< per node: a foreign body has it, too
  /// Supports and the axis r = 0 (u_r); prescribed dofs and those of hanging nodes, too.
  std::vector<bool> fixed_dof;
  Eigen::VectorXd prescribed_displacement_m;  ///< per dof, amplitude excluded; 0 on supports
  std::vector<int> prescribed_index;          ///< per dof: which Body::prescribed moves it along itself, -1 none
  std::vector<int> turned_by;                 ///< per node: which Body::prescribed turns it, -1 none
  Eigen::VectorXd damping_kg_s;            ///< per dof: dashpots of the absorbing surfaces; 0 elsewhere and where held
  Eigen::VectorXd initial_displacement_m;  ///< per dof (on prescribed dofs their value at t = 0)
  Eigen::VectorXd initial_velocity_m_s;    ///< per dof (0 on fixed dofs)
};

/// Whether a degree of freedom is held where it was: nothing prescribed moves it.
[[nodiscard]] inline bool is_still(const BodyProblem& body, int dof) {
  const auto i = static_cast<std::size_t>(dof);
  return body.fixed_dof[i] && body.prescribed_index[i] < 0 &&
         body.turned_by[i / static_cast<std::size_t>(fem::components(body.section.model))] < 0;
}

/// Where a foreign body is joined to one of the scene's.
struct Joint {
  std::string foreign;     ///< name of the foreign body
  int body = -1;           ///< index into Problem::bodies
  std::vector<int> nodes;  ///< of that body's mesh, ascending
};

struct Problem {
  Scene scene;
  std::vector<BodyProblem> bodies;        ///< in the scene's order
  std::vector<Joint> joints;              ///< in the order of the scene's foreign bodies
  std::vector<ContactGeometry> contacts;  ///< in the scene's order, none without pairs
  WindowClock clock;                      ///< of windows Delta t, from step_s or the safety factor
  double windows_of_scene = 0.0;  ///< up to the end of the scene; one that goes on may have another end and step
  /// Per body, if Delta t is from the safety factor: the critical step of its explicit elements (explicit_elements)
  /// that was found for it [s]; else empty.
  std::vector<double> critical_time_steps_s;
};

/// Whether a body has a material with plasticity.
[[nodiscard]] inline bool yields(const Problem& problem) {
  return std::any_of(problem.scene.bodies.begin(), problem.scene.bodies.end(),
                     [](const Body& body) { return body.yields(); });
}

/// Whether plastic work heats a body.
[[nodiscard]] inline bool heats(const Problem& problem) {
  return std::any_of(problem.scene.bodies.begin(), problem.scene.bodies.end(),
                     [](const Body& body) { return body.heats(); });
}

/// The material of an element that has all these nodes: what is behind a face, or at a node.
[[nodiscard]] const fem::Material& material_at(const BodyProblem& body, const fem::Face& nodes);
/// That of a body where a contact is.
[[nodiscard]] const fem::Material& contact_material(const Problem& problem, const ContactGeometry& contact, int body);
/// The fastest wave in any element of a body [m/s].
[[nodiscard]] double fastest_wave_m_s(const BodyProblem& body);

/// Whether no body yields or turns: P = K u of all elements.
[[nodiscard]] inline bool linear(const Problem& problem) {
  return !yields(problem) && std::none_of(problem.scene.bodies.begin(), problem.scene.bodies.end(),
                                          [](const Body& body) { return body.large_rotation; });
}

/// The direction that momentum is balanced along, and tangent_of it: the normal of the first contact; without one, the
/// axis.
[[nodiscard]] inline Eigen::Vector3d momentum_normal(const Problem& problem) {
  if (!problem.contacts.empty()) return problem.contacts.front().named_normal;
  return Eigen::Vector3d::Unit(problem.scene.components() - 1);
}

/// Builds meshes and partitions. `baseline` protocols: all_implicit makes every element implicit, all_explicit none.
/// Shared nodes, and contact nodes unless all_explicit, are implicit nodes. Throws ConfigError
/// (names scene file, key, and the nodes where surfaces do not match under a law that needs pairs of nodes).
[[nodiscard]] Problem build_problem(const Scene& scene);
/// The same but for the clock, whose windows stay 0: a participant hears it from the coupler.
[[nodiscard]] Problem build_bodies(const Scene& scene);

/// The surfaces of a contact whose bodies have turned, each about a place of its own that stays where it is.
struct TurnedSurfaces {
  fem::RigidMotion first, second;
  surface::ContactMesh mesh;
};
[[nodiscard]] TurnedSurfaces turned_surfaces(const surface::ContactMesh& mesh, const fem::RigidMotion& first,
                                             const fem::RigidMotion& second);
/// The pairs of a contact that slides, once the second body has moved by `shift_m`, lifted_m in it, against the first,
/// and both have turned; sorted by distance, without nodes that lie opposite nothing. `turned`: null where none has.
[[nodiscard]] std::vector<ContactPair> slid_pairs(const Problem& problem, std::size_t contact,
                                                  const Eigen::Vector3d& shift_m, const TurnedSurfaces* turned);

/// The contact nodes of a body, ascending; empty if it takes no part in the contact, or in any.
[[nodiscard]] std::vector<int> contact_nodes(const ContactGeometry& contact, int body);
[[nodiscard]] std::vector<int> contact_nodes(const std::vector<ContactGeometry>& contacts, int body);

/// Per node of a body: explicit participants and the implicit one share it. Explicit elements, or those of a foreign
/// body, touch it, and it is integrated implicitly. None in the baselines.
[[nodiscard]] std::vector<bool> shared_nodes(const Problem& problem, int body);

/// The parts a participant owns, in the scene's order of bodies; a body without elements (and, for the implicit side,
/// without contact nodes) of this participant is left out.
struct ParticipantPart {
  int body = -1;  ///< index into Problem::bodies
  fem::Part part;
  std::vector<int> shared;  ///< local nodes shared with other participants, ascending body node
  /// For a share of a part (part_share): per local node, whether its rows are complete; the whole part's numbering.
  std::vector<bool> own;
  fem::Numbering numbering;
};
[[nodiscard]] std::vector<ParticipantPart> participant_parts(const Problem& problem,
                                                             const ParticipantSpec& participant);

/// The share of one body's part for a process that steps no more than the nodes `own`: the elements around them.
/// `whole`: the part's nodes, `own` and `with` some of them, all as the body numbers them, ascending; `with` and the
/// nodes of those elements are this part's nodes. Rows of K of nodes that are not `own` are left empty.
[[nodiscard]] ParticipantPart part_share(const Problem& problem, int body, const ParticipantSpec& participant,
                                         const std::vector<int>& whole, const std::vector<int>& own,
                                         const std::vector<int>& with);

/// Per element of a body: a participant owns it. An explicit one owns explicit elements of its bodies (of its groups),
/// the implicit one all implicit elements.
[[nodiscard]] std::vector<bool> owned_elements(const Scene& scene, const BodyProblem& body,
                                               const ParticipantSpec& participant);

/// External nodal forces on the nodes of a part at a time: tractions and gravity of its own elements [N].
class ExternalForce {
 public:
  ExternalForce() = default;  ///< no load
  ExternalForce(const Body& body, const fem::Part& part);
  [[nodiscard]] bool zero() const { return terms_.empty(); }
  /// Per dof of the part: some load acts on it at some time.
  [[nodiscard]] std::vector<bool> loaded(int dofs) const;
  /// Adds nothing and allocates nothing where there is no load. `force` has part.dofs() entries, overwritten.
  void at(double time_s, Eigen::VectorXd& force) const;
  /// `change(force)` of every load's share, once and for all.
  template <class Change>
  void transform(const Change& change) {
    for (Term& term : terms_) change(term.force);
  }

 private:
  struct Term {
    Amplitude amplitude;
    Eigen::VectorXd force;
  };
  std::vector<Term> terms_;
};

}  // namespace ricochet::scene
