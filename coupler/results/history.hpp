#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/ledger.hpp"
#include "common/base/window_clock.hpp"

namespace ricochet::coupler {

/// One window of the whole structure.
struct HistoryRow {
  std::int64_t window = 0;
  double time_s = 0;
  std::vector<BodyTotals> bodies;  ///< over all participants, in the scene's order
  BodyTotals sum;                  ///< over the bodies; momentum and impulse too
  ContactRecord contact;
  /// Energy that a participant holds beyond what it was given through loads and its link, since the first row [J]:
  /// E - E_0 + plastic work + friction - external - interface. Zero for an exact method; says where energy is made when
  /// a run blows up.
  std::vector<double> created_j;
  double energy_error = 0;        ///< see Errors
  double energy_reference_j = 0;  ///< what energy_error is relative to
  double momentum_error = 0;
  double momentum_reference_kg_m_s = 0;            ///< what momentum_error is relative to
  std::optional<double> angular_momentum_error{};  ///< empty: it is not balanced, or somebody does not tell it
};

/// Energy that nobody gave: kinetic + strain + plastic work + friction - external - E_0, with E_0 the kinetic + strain
/// + plastic work of the first row.
class EnergyBalance {
 public:
  /// The energy that this row has created [J].
  double created_j(const HistoryRow& row);
  /// max(E_0, largest |external| so far) [J]
  [[nodiscard]] double reference_j() const { return std::max(first_j_.value_or(0.0), largest_work_j_); }
  /// The first row held more than what came from outside since.
  [[nodiscard]] bool mostly_initial() const { return first_j_.value_or(0.0) > largest_work_j_; }
  void archive(Archive& a) { a(first_j_, largest_work_j_); }

 private:
  std::optional<double> first_j_;
  double largest_work_j_ = 0;
};

/// Which momenta a scene conserves.
struct Conserved {
  struct Direction {
    double n = 0, t = 0, b = 0;  ///< components along the contact normal, the tangent and, of solids, the binormal
  };
  std::vector<Direction> directions = {{1, 0}, {0, 1}};
  /// Half the scene's extent, by which momentum becomes the scale of angular momentum; 0: angular momentum is not
  /// balanced [m].
  double arm_m = 0;
};

/// Which balances everybody tells of; the errors of others are nan.
struct ToldBalances {
  bool energy = true, momentum = true;
};

/// Relative errors of the balances, from row to row.
///   energy_error   = EnergyBalance::created_j / reference_j
///   momentum_error = |p - impulse - p_0| / largest sum over the bodies of |p_body| so far, largest over the conserved
///   directions; of bodies that turn or vibrate on the spot |p_body| is rounding, and sqrt(2 m E_kin) stands in its
///   place, which is |p| of a body that moves as a whole
///   angular_momentum_error = |L - angular impulse - L_0| / (arm_m times the same sum), L a vector
/// Zero where the reference is zero.
class Errors {
 public:
  explicit Errors(Conserved conserved = {}, ToldBalances told = {}) : conserved_(std::move(conserved)), told_(told) {}
  void add(HistoryRow& row);
  void archive(Archive& a) { a(energy_, first_, first_angular_, largest_momentum_); }

 private:
  Conserved conserved_;
  ToldBalances told_;
  EnergyBalance energy_;
  std::vector<double> first_;  ///< per direction
  std::array<double, 3> first_angular_{};
  double largest_momentum_ = 0;
};

/// Merges the history rows of all participants by window. Sums run over the bodies in the scene's order and within a
/// body over the participants in the scene's order, so that they do not depend on how bodies are spread over processes.
///
/// Columns of a participant: "window"; per body "<quantity>/<body>" with the members of BodyTotals as quantities, the
/// plastic ones of bodies that yield; "energy_interface_j", the work its link did on it, if it is not given per body;
/// of the contact's owner the members of ContactRecord and, of each of several contacts, "<quantity>/<contact>" with
/// those of ContactTotals.
class History {
 public:
  struct Source {
    std::string participant;
    std::vector<std::string> columns;
  };
  /// `contacts`: names of several. Throws ProtocolError naming the participant and the column if a column is unknown,
  /// given twice or missing. Without the angular momenta of everyone that balance is none.
  History(const std::vector<Source>& sources, const std::vector<std::string>& bodies, Conserved conserved = {},
          const std::vector<std::string>& contacts = {}, ToldBalances told = {});

  /// `values`: rows of this participant, row-major. Throws ProtocolError if windows do not ascend.
  void add(std::size_t participant, const std::vector<double>& values);
  /// The next window that every participant has reported, with its errors. Throws ProtocolError if windows disagree.
  std::optional<HistoryRow> next(const WindowClock& clock);
  /// Every participant tells the work that its link did on it, so that what the interface itself makes is known.
  [[nodiscard]] bool tells_interface() const { return tells_interface_; }
  /// Rows that wait for others, and what the errors refer to.
  void archive(Archive& a);

 private:
  struct Column {
    int body = -1;  ///< -1: of the participant
    double BodyTotals::*of_body = nullptr;
    double ContactRecord::*of_contacts = nullptr;  ///< of all together
    std::size_t contact = 0;
    double ContactTotals::*of_one_contact = nullptr;
  };
  struct Stream {
    std::string participant;
    std::vector<Column> columns;
    std::deque<std::vector<double>> rows;
    double last_window = -1;
    std::optional<double> first_created_j;

    void archive(Archive& a);
  };
  [[nodiscard]] Column parse(const std::string& column, const std::string& participant) const;
  [[nodiscard]] std::optional<Column> parse_named(const std::string& quantity, const std::string& name) const;
  void check_windows() const;
  void merge(Stream& stream, HistoryRow& row) const;

  std::vector<std::string> bodies_, contacts_;
  std::vector<Stream> streams_;
  Errors errors_;
  bool tells_interface_ = false;
};

/// Names of the contacts that the columns of a participant are of, where there are several.
[[nodiscard]] std::vector<std::string> contacts_named_in(const std::vector<std::string>& columns);

}  // namespace ricochet::coupler
