#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace ricochet::coupler {

/// Totals of one body over all participants at the end of a window.
struct BodyRow {
  double mass_kg = 0, energy_kinetic_j = 0, energy_strain_j = 0, energy_external_j = 0;
  double momentum_n_kg_m_s = 0, momentum_t_kg_m_s = 0, impulse_n_kg_m_s = 0, impulse_t_kg_m_s = 0;
  double energy_interface_j = 0;
};

/// What the owner of the contact reports.
struct ContactRow {
  double gap_min_m = 0, contact_force_n = 0, contact_pressure_mean_pa = 0, principal_stress_mean_pa = 0,
         friction_force_n = 0;
  double pairs_stick = 0, pairs_slip = 0, pairs_open = 0;
  double energy_contact_j = 0, energy_friction_j = 0, contact_impulse_n_s = 0, friction_impulse_n_s = 0;
  double contact_iterations = 0, contact_residual = 0, contact_unconverged = 0;
};

/// One window of the whole structure.
struct HistoryRow {
  std::int64_t window = 0;
  double time_s = 0;
  std::vector<BodyRow> bodies;  ///< in the scene's order
  BodyRow sum;                  ///< over the bodies; momentum and impulse too
  ContactRow contact;
  /// Energy that a participant holds beyond what it was given through loads and its link, since the first row [J]:
  /// E - E_0 + friction - external - interface. Zero for an exact method; says where energy is made when a run blows
  /// up.
  std::vector<double> created_j;
  double energy_error = 0;  ///< see Errors
  double momentum_error = 0;
};

/// Relative errors of the balances, from row to row.
///   energy_error   = (kinetic + strain + friction - external - E_0) / E_ref,  E_0 kinetic + strain of the first row,
///                    E_ref = max(E_0, largest |external| so far)
///   momentum_error = |p - impulse - p_0| / largest sum over the bodies of |p_body| so far,
///                    the larger of the normal and, where it is a momentum at all, the tangential component
/// Zero where the reference is zero.
class Errors {
 public:
  /// `tangential_conserved`: false in axisymmetry, where the tangent is radial and the sum over the ring no momentum.
  explicit Errors(bool tangential_conserved) : tangential_conserved_(tangential_conserved) {}
  void add(HistoryRow& row);
  [[nodiscard]] double reference_energy_j() const { return reference_energy_j_; }
  [[nodiscard]] double first_energy_j() const { return first_energy_j_; }

 private:
  bool tangential_conserved_;
  bool first_ = true;
  double first_energy_j_ = 0, reference_energy_j_ = 0;
  double first_n_ = 0, first_t_ = 0, largest_momentum_ = 0;
};

/// Merges the history rows of all participants by window. Sums run over the bodies in the scene's order and within a
/// body over the participants in the scene's order, so that they do not depend on how bodies are spread over processes.
///
/// Columns of a participant: "window"; per body "<quantity>/<body>" with the members of BodyRow as quantities;
/// "energy_interface_j", the work its link did on it, if it is not given per body; of the contact's owner the members
/// of ContactRow.
class History {
 public:
  struct Source {
    std::string participant;
    std::vector<std::string> columns;
  };
  /// Throws ProtocolError naming the participant and the column if a column is unknown, given twice or missing.
  /// `tangential_conserved`: see Errors.
  History(const std::vector<Source>& sources, const std::vector<std::string>& bodies, double window_size_s,
          bool tangential_conserved = true);

  /// `values`: rows of this participant, row-major. Throws ProtocolError if windows do not ascend.
  void add(std::size_t participant, const std::vector<double>& values);
  /// The next window that every participant has reported, with its errors. Throws ProtocolError if windows disagree.
  std::optional<HistoryRow> next();
  [[nodiscard]] const Errors& errors() const { return errors_; }

 private:
  struct Column {
    int body = -1;  ///< -1: of the participant
    double BodyRow::*of_body = nullptr;
    double ContactRow::*of_contact = nullptr;
  };
  struct Stream {
    std::string participant;
    std::vector<Column> columns;
    std::deque<std::vector<double>> rows;
    double last_window = -1;
    std::optional<double> first_created_j;
  };
  [[nodiscard]] Column parse(const std::string& column, const std::string& participant) const;
  void check_windows() const;
  void merge(Stream& stream, HistoryRow& row) const;

  std::vector<std::string> bodies_;
  std::vector<Stream> streams_;
  double window_size_s_;
  Errors errors_;
};

}  // namespace ricochet::coupler
