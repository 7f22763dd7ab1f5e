#pragma once

#include <string>
#include <vector>

#include "common/problem/problem.hpp"

/// The steps of build_problem, in their order. Internal to common/problem and common/check.
namespace ricochet::scene {

/// Mesh of a body, structured or read, checked.
[[nodiscard]] fem::Mesh build_mesh(const Scene& scene, const Body& body);

/// Ties of a body: on each pair of surfaces the nodes of that with the shorter edges hang on the nodes of the other, by
/// the weights of the dual mortar (mortar.hpp), so that tractions of one side are in balance with those of the other.
/// Nodes beside the other surface stay free. Likewise on foreign bodies with faces of their own, whose nodes become
/// nodes of this mesh. Throws ConfigError for an unknown surface, surfaces that lie nowhere opposite or not on each
/// other, a node that would hang twice, and a piece that no tie joins to the others.
void tie_pieces(const Scene& scene, const Body& body, fem::Mesh& mesh);

/// Gives a rigid body few nodes more (Mesh::rigid_nodes), whose affine motion all others follow, so that
///   u(x) = b + A x,   M = m / (n + 1) of each,   K = V D of the homogeneous strain,
/// n being the number of components in which it moves freely: the others, which supports, prescribed motion or the
/// axis of symmetry hold anywhere, are those of one node. With carriers at the corners of a regular simplex, stretched
/// by the root of the second moment of mass over m about the centre, this lumped M is that of the motion without loss,
/// so that mass, centre of mass, momenta and kinetic energy are those of the body (Cohen and Muncaster, The Theory of
/// Pseudo-rigid Bodies, 1988). Throws ConfigError for a body that a foreign one is joined to.
void make_rigid(const Scene& scene, const Body& spec, BodyProblem& body);
/// Multiplies Young's moduli of rigid bodies so that the strain of each vibrates as fast as the finest element of the
/// other bodies, but for a margin: as stiff as they can be without a shorter step.
void stiffen_rigid(Problem& problem);

/// Supports, the axis r = 0 and prescribed motion: fixed_dof, prescribed_displacement_m, prescribed_index, turned_by.
/// Throws ConfigError for an unknown surface and where a prescribed displacement meets another or a support, or a turn
/// another or a support.
void set_constraints(const Scene& scene, const Body& spec, BodyProblem& body);

/// Initial displacement (linear along the axis) and velocity. Throws ConfigError where it moves a support.
void set_initial_state(const Scene& scene, const Body& spec, BodyProblem& body);

/// damping_kg_s of the absorbing surfaces. Throws ConfigError for an unknown surface, one that is perpendicular to no
/// coordinate, one without area, and one that is held along its normal.
void set_absorbing(const Scene& scene, const Body& spec, BodyProblem& body);
/// Throws ConfigError if a contact node lies on an absorbing surface.
void refuse_absorbing_contact(const Problem& problem);

/// Pairs of the contact surfaces. Throws ConfigError for unknown surfaces and such as lie nowhere opposite, for bodies
/// that overlap, and for a pair that is held in the normal direction on every side.
[[nodiscard]] std::vector<ContactGeometry> build_contacts(const Scene& scene, const std::vector<BodyProblem>& bodies);

/// The nodes that foreign bodies share with the scene's: those of a surface, or those nearest to the positions of a
/// file, each closer than 1e-6 of the body's extent. Sets joined_node of every body. Throws ConfigError for an unknown
/// surface, for a position without a node and for two positions of one node.
[[nodiscard]] std::vector<Joint> build_joints(const Scene& scene, std::vector<BodyProblem>& bodies);

/// implicit_element and implicit_node of every body, by the protocol's layout and the partition's rule.
void set_partition(Problem& problem);

/// The step that the automatic partition asks the elements of a body to bear [s]: the longest window, or its substep.
[[nodiscard]] double automatic_step_s(const Scene& scene, const std::string& body);
/// Per element: a node that carries it (fem::for_each_carrier) is among these, which ascend.
[[nodiscard]] std::vector<bool> elements_at(const fem::Mesh& mesh, const std::vector<int>& nodes);

/// Per node: carries one of the elements.
[[nodiscard]] std::vector<bool> touched_nodes(const BodyProblem& body, const std::vector<bool>& of_element);

/// Throws ConfigError, led by file, line and key, if `surface` is not in the mesh.
void require_surface(const Scene& scene, const std::string& key, const fem::Mesh& mesh, const std::string& surface);

[[nodiscard]] inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace ricochet::scene
