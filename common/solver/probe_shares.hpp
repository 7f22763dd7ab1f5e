#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "common/body/body_state.hpp"
#include "common/problem/probes.hpp"

namespace ricochet::solver {

/// The shares of a participant in the probes and gauges of the scene. Motion at a place is the sum N_i u_i over the
/// nodes of its element; each node counts where it is integrated, so that a node that two processes share counts once.
/// Strain is that of the element B u, stress D B u less what plastic strain takes off it in the element's middle, and
/// counts where the element is owned; of a gauge each point has its share. The coupler adds the shares of all
/// participants up.
class ProbeShares {
 public:
  ProbeShares() = default;  ///< no place
  /// No place, too, if the scene asks for none. `states`: as they will be given to `append`.
  ProbeShares(const scene::Problem& problem, const std::vector<BodyState>& states);

  /// See participant::Description::probe_columns.
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  /// The degrees of freedom of a part that it reads, ascending.
  [[nodiscard]] std::vector<int> dofs_of(std::size_t part, int components) const;
  /// Throws as `require_finite` does. `window`: for the error text.
  void append(const std::vector<BodyState>& states, std::int64_t window, std::vector<double>& row) const;

 private:
  /// Motion at a place: shares of own nodes.
  struct Motion {
    std::size_t part = 0;
    std::vector<std::pair<int, double>> nodes;  ///< local node, N_i
  };
  /// Linear in the motion of one element: rows are strains, then stresses.
  struct Strained {
    std::size_t part = 0;
    std::vector<int> dofs;
    Eigen::MatrixXd rows;
    bool probe = false;  ///< von Mises stress follows and, where the body yields, equivalent plastic strain
    /// Local elements of a part that yields, and their shares.
    std::vector<std::pair<int, double>> plastic{};
  };
  struct Told {
    std::vector<Motion> motion;     ///< of a probe whose element has own nodes: one
    std::vector<Strained> strains;  ///< of own elements: one, a participant has one part of a body
  };
  void add(const scene::Problem& problem, const scene::MeasuredPlace& place, const std::vector<BodyState>& states,
           const std::vector<std::string>& names);
  static void add_plastic(const std::vector<scene::StrainPoint>& points, const BodyState& state, Strained& strained);
  static void add_strain_of_probe(const scene::BodyProblem& body, const scene::StrainPoint& point, std::size_t part,
                                  const BodyState& state, Told& told);
  static void add_strain_of_gauge(const scene::BodyProblem& body, const std::vector<scene::StrainPoint>& points,
                                  std::size_t part, const BodyState& state, Told& told);
  [[nodiscard]] static Eigen::VectorXd values_of(const Strained& strained, const BodyState& state);
  static void add_motion(const scene::BodyProblem& body, const scene::StrainPoint& point, std::size_t part,
                         const BodyState& state, Told& told, double& share);

  std::vector<std::string> columns_;
  std::vector<Told> told_;
};

}  // namespace ricochet::solver
