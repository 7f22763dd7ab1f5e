#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>
#include <string>
#include <vector>

#include "common/fem/element.hpp"
#include "common/fem/mesh.hpp"

namespace ricochet::fem {

/// Eigen's, which copies what it is asked to move: K is the largest of what a process has.
class SparseMatrix : public Eigen::SparseMatrix<double, Eigen::RowMajor, int> {
 public:
  using Base = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;
  using Base::Base;
  using Base::operator=;
  SparseMatrix() = default;
  ~SparseMatrix() = default;
  SparseMatrix(const SparseMatrix&) = default;
  SparseMatrix& operator=(const SparseMatrix&) = default;
  SparseMatrix(SparseMatrix&& other) noexcept { swap(other); }
  SparseMatrix& operator=(SparseMatrix&& other) noexcept {
    swap(other);
    return *this;
  }
};

/// The elements of one body that one participant owns, in local node numbers, assembled.
/// Parts of one body are always processed body by body, so that a history does not depend on how bodies are spread
/// over participants.
struct Part {
  std::string body;
  Section section;
  Material material;
  Mesh mesh;                      ///< local numbering; groups and surfaces restricted to this part
  std::vector<int> body_node;     ///< local node -> node of the whole body's mesh
  std::vector<int> body_element;  ///< local element -> element of the whole body's mesh
  Eigen::VectorXd lumped_mass;    ///< per local node, own elements only [kg]
  SparseMatrix stiffness;         ///< own elements only, dof x dof, structurally symmetric [N/m]

  [[nodiscard]] int nodes() const { return static_cast<int>(mesh.position.size()); }
  [[nodiscard]] int dofs() const { return nodes() * components(mesh.model); }
};

/// Part made of the listed elements of `whole` (in ascending order), plus `extra_nodes` that may belong to no element
/// of it (contact nodes whose elements another participant owns; their mass here is 0). Nodes in ascending order. Every
/// surface of `whole` keeps its name and holds the faces of own elements only, possibly none, so that a load is taken
/// by one part. Carriers of hanging nodes are nodes of the part, too; hanging nodes have neither mass nor stiffness
/// there (hanging_nodes.hpp). Mass and stiffness are summed in a fixed order: bit-identical for the same elements
/// whatever else the participant owns.
[[nodiscard]] Part extract_part(const Mesh& whole, const std::string& body, const Section& section,
                                const Material& material, const std::vector<int>& elements,
                                const std::vector<int>& extra_nodes = {});

/// One element of a mesh, for the functions of element.hpp.
[[nodiscard]] ElementGeometry element_geometry(const Mesh& mesh, int element);
/// Extent of an element along a direction [m].
[[nodiscard]] double extent_along(const ElementGeometry& element, const Eigen::Vector3d& direction);
/// Displacements of one element's nodes out of a node-major vector.
[[nodiscard]] ElementVector element_displacement(const Mesh& mesh, int element, const Eigen::VectorXd& u);

/// Integral of N_i dA over a face, per node of it [m^2] (bar: the cross section).
using FaceArea = std::array<double, 4>;  ///< 0 beyond the nodes of the face
[[nodiscard]] FaceArea face_area(const Section& section, const Mesh& mesh, const Face& face);

/// Outward unit normal of a face that is not the end of a bar; of a quadrilateral that is not flat its mean one.
[[nodiscard]] Eigen::Vector3d face_normal(const Mesh& mesh, const Face& face);

/// Smallest critical time step over the elements by the element bound, 2 / max omega_e [s]; infinity without elements.
[[nodiscard]] double element_critical_time_step(const Part& part);

/// omega_max^2 of K x = omega^2 M x by Lanczos on the assembled part, to `tolerance` relative, from below (so
/// 2/omega_max errs upwards by half of it); where that takes more than a tenth of a second or so, counted in rows of
/// products, to `rough`, if that is more. The products that another digit takes grow with the mesh, those
/// of the first three hardly do; `mass` per node [kg], positive where a degree of freedom is free
/// (std::invalid_argument otherwise); dofs with `fixed_dof` true left out; 0 if none is free [1/s^2].
/// Throws SolverError if it does not converge. The same input gives the same bits.
[[nodiscard]] double max_frequency_squared(const SparseMatrix& stiffness, const Eigen::VectorXd& mass, int components,
                                           const std::vector<bool>& fixed_dof, double tolerance = 1e-6,
                                           double rough = 0.0);
/// force = K u [N] of a symmetric K that need not be a matrix.
using TimesStiffness = std::function<void(const Eigen::VectorXd& u, Eigen::VectorXd& force)>;
[[nodiscard]] double max_frequency_squared(const TimesStiffness& stiffness, const Eigen::VectorXd& mass, int components,
                                           const std::vector<bool>& fixed_dof, double tolerance, double rough = 0.0);
class StiffnessProduct;
/// A lower bound of the same by `products` steps of that Lanczos, one product with K each [1/s^2]. Ten come within some
/// ten per cent of it in most meshes.
[[nodiscard]] double frequency_squared_at_least(const StiffnessProduct& stiffness, const Eigen::VectorXd& mass,
                                                int components, const std::vector<bool>& fixed_dof, int products);
[[nodiscard]] double frequency_squared_at_least(const TimesStiffness& stiffness, const Eigen::VectorXd& mass,
                                                int components, const std::vector<bool>& fixed_dof, int products);

/// Nodal forces of a constant traction [Pa per component] on a surface of the part (node-major) [N].
/// ConfigError if the body has no such surface; zero if no face of it is this part's.
[[nodiscard]] Eigen::VectorXd traction_force(const Part& part, const std::string& surface,
                                             const std::vector<double>& traction_pa);

/// The same of a pressure [Pa] against the outward normal, of which a quadrilateral that is not flat has its mean one.
[[nodiscard]] Eigen::VectorXd pressure_force(const Part& part, const std::string& surface, double pressure_pa);

/// Nodal forces of a body force per unit mass [m/s^2 per component], consistent with the lumped mass [N].
[[nodiscard]] Eigen::VectorXd gravity_force(const Part& part, const std::vector<double>& gravity_m_s2);

}  // namespace ricochet::fem
