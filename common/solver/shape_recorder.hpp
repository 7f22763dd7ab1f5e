#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/base/window_clock.hpp"
#include "common/body/body_state.hpp"
#include "common/contact/contact_surface.hpp"
#include "common/fem/seen_cells.hpp"
#include "common/participant/participant.hpp"

namespace ricochet::solver {

/// Keeps the displacements of a participant's elements at a few windows, evenly spaced over the run however long it
/// becomes, and at a few more spaced evenly over what time bodies touch, and writes them with the stress and the
/// contact pressure of what can be seen to DIRECTORY/NAME.shapes.json, from which `ricochet report` draws the deformed
/// bodies. Stresses are reckoned at the end, and for those windows alone: while the run goes on, a window costs a copy
/// of u at most. It is a picture only: if it cannot be written, a line on stderr says so and nothing fails; in a folder
/// that is not there (on another machine) it does not try. The file says how many cells there are, and has none, if
/// they are more than SeenCells::most.
class ShapeRecorder {
 public:
  /// Windows kept; one more when this many are there: then every second goes, and half as many are kept from there on.
  static constexpr std::size_t most_windows = 8, most_touching = 6;

  /// Keeps nothing if `setup` has no output directory. `states` must outlive this object unmoved, and so must
  /// what `pressing` names, of who enforces the contact. Its parts have nodes of `states`, some or all.
  ShapeRecorder(const scene::Problem& problem, const std::vector<BodyState>& states, const participant::Setup& setup,
                std::string participant, PressedSurface pressing);
  ShapeRecorder(const ShapeRecorder&) = delete;
  ShapeRecorder& operator=(const ShapeRecorder&) = delete;
  /// Writes what there is of a run that did not come to its end.
  ~ShapeRecorder();

  /// Before `note`: whether contact was closed before that window, as all participants are told.
  void note_touch(bool closed) {
    touches_ = closed;
    if (closed) ++touched_;
  }
  /// After `window` is accepted, and at the start; takes no memory from the heap.
  void note(std::int64_t window);
  /// Whether that keeps the motion, or may.
  [[nodiscard]] bool due(std::int64_t window) const {
    return !path_.empty() && (window % run_.every == 0 || (touches_ && (touched_ - 1) % touching_.every == 0));
  }
  /// After the last window, which is kept whatever its number.
  void finish(std::int64_t window);
  /// The windows kept so far.
  void archive(Archive& a);

 private:
  /// The drawing of one part: nodes, and cells of two to four of them.
  struct Drawn {
    std::string name;
    double strip_m = 0.0;                   ///< of a bar: the side of a square of its cross section
    Eigen::Vector3d velocity_m_s{0, 0, 0};  ///< mean over the body at the start
    std::vector<int> node;                  ///< of the part
    std::vector<int> body_node;             ///< its number in the body; < 0: the image of a node across the period
    std::vector<bool> hangs;                ///< its carriers have the rows of the contact
    std::vector<float> position_m;          ///< `components` per node
    std::vector<std::array<int, 4>> cells;  ///< indices into `node`, -1 beyond a cell's own
    std::vector<int> element;               ///< of the part, per cell
    std::vector<int> kept_dof;              ///< of all nodes of these elements
    /// Displacement of those and, of a part that yields, what its plastic strain takes off the stress of each cell's
    /// element, the equivalent plastic strain and the rise of temperature; of who enforces the contact its pressure on
    /// each cell; of a part that turns also its frame.
    std::array<Eigen::VectorXd, most_windows + 1 + most_touching + 1> kept;
    Eigen::VectorXd load_n, area_m2;  ///< contact forces and areas of the present window, per dof of the part
    std::vector<int> pressed_node;    ///< of the part, per node that rows of the contact number
  };
  /// Windows kept of those that come one after the other, numbered by `count`.
  struct Series {
    std::size_t most, first;  ///< of Drawn::kept
    std::vector<std::int64_t> windows{};
    std::int64_t every = 1;
  };
  /// A window that is kept, and where.
  struct Kept {
    std::int64_t window;
    std::size_t slot;
  };
  [[nodiscard]] Drawn drawn_part(const BodyState& state, const scene::BodyProblem& body, fem::SeenCells&& seen) const;
  void note(Series& series, std::int64_t count, std::int64_t window);
  void keep(Series& series, std::int64_t window);
  [[nodiscard]] std::vector<Kept> kept() const;
  void write();
  void press();
  [[nodiscard]] double pressure_pa(const Drawn& part, std::size_t cell) const;
  [[nodiscard]] Eigen::Index first_pressure(std::size_t part) const;
  [[nodiscard]] std::string text() const;
  [[nodiscard]] std::string text_of(std::size_t part, const std::vector<Kept>& kept) const;

  const std::vector<BodyState>& states_;
  PressedSurface pressing_;
  std::string path_, participant_;
  fem::Model model_ = fem::Model::bar;
  const WindowClock* clock_;
  bool nose_ = false;    ///< of a contact
  bool uneven_ = false;  ///< gaps of the meshes differ over a contact, its bodies slide, or one turns
  std::vector<Drawn> parts_;
  std::size_t too_many_cells_ = 0;            ///< how many there are; 0: not too many
  std::vector<std::string> touching_bodies_;  ///< as JSON: the two of each contact, "" what is rigid
  Series run_{most_windows, 0}, touching_{most_touching, most_windows + 1};
  bool touches_ = false;
  std::int64_t touched_ = 0;  ///< windows so far before which contact was closed
};

}  // namespace ricochet::solver
