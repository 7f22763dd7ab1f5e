#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Causes of a difference between what a participant says and what the scene says. Each is tried before it is named:
/// with it what was found is what was expected, at every node.
namespace ricochet::coupler {

/// A share of the largest expected number: other quadrature and rounding pass, one percent does not.
inline constexpr double comparison_tolerance = 1e-3;

/// Largest |value|; 0 of none.
[[nodiscard]] double largest(const std::vector<double>& values);
[[nodiscard]] bool agree(const std::vector<double>& found, const std::vector<double>& expected);
/// The factor between two vectors, if it is one for all rows.
[[nodiscard]] std::optional<double> common_factor(const std::vector<double>& found,
                                                  const std::vector<double>& expected);

/// Names a number that is `ratio` times the right one: of the wrong sign, per radian, in another unit; empty: nothing
/// that a factor alone tells.
[[nodiscard]] std::string known_slip(double ratio);

/// Another meaning of the numbers of a link: number i is `sign[i]` times what stands at `row[i]`.
struct Arrangement {
  std::string name;
  std::vector<std::size_t> row;
  std::vector<double> sign;

  [[nodiscard]] std::vector<double> applied(const std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> undone(const std::vector<double>& values) const;
};
/// `bodies`: per node; `axes`: names of the components, "x", "y".
[[nodiscard]] std::vector<Arrangement> other_arrangements(const std::vector<double>& bodies,
                                                          const std::vector<std::string>& axes);

/// How all of some places become the scene's: in millimetres, their coordinates exchanged, mirrored, turned by right
/// angles. `is_there(i, x)`: place i of the scene's kind is at x. Empty: not by any of these.
[[nodiscard]] std::string places_cause(const std::vector<Eigen::Vector3d>& places, const std::vector<std::string>& axes,
                                       const std::function<bool(std::size_t, const Eigen::Vector3d&)>& is_there);

/// "; likely cause: ..." of a cause that is not empty.
[[nodiscard]] std::string as_cause(const std::string& text);

}  // namespace ricochet::coupler
