// Contact is found where bodies are: a flight of any length before it changes nothing.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

constexpr double radius_m = 0.01, step_s = 5e-8, speed_m_s = 10.0;

/// MSH 4.1 text of a disc of cells x cells quadrilaterals, on rays from its middle outwards, whose surface "cap" is the
/// upper or the lower part of its circle.
std::string disc_of(const std::string& body, double x, double y, int cells, bool upper) {
  const int row = cells + 1;
  std::vector<std::pair<double, double>> places;
  for (int k = 0; k < row * row; ++k) {
    const double a = 2.0 * (k % row) / cells - 1.0, b = 2.0 * (k / row) / cells - 1.0;
    const double out = std::max(std::abs(a), std::abs(b)), quarter = std::numbers::pi / 4.0;
    double across = 0.0, up = 0.0;
    if (out > 0.0 && std::abs(a) >= std::abs(b)) {
      across = std::copysign(out * std::cos(quarter * b / a), a);
      up = std::copysign(out, a) * std::sin(quarter * b / a);
    } else if (out > 0.0) {
      up = std::copysign(out * std::cos(quarter * a / b), b);
      across = std::copysign(out, b) * std::sin(quarter * a / b);
    }
    places.emplace_back(x + radius_m * ((1.0 - out) * 0.75 * a + out * across),
                        y + radius_m * ((1.0 - out) * 0.75 * b + out * up));
  }
  std::vector<int> ring;  // counter-clockwise
  for (int i = 0; i < cells; ++i) ring.push_back(i);
  for (int j = 0; j < cells; ++j) ring.push_back(j * row + cells);
  for (int i = cells; i > 0; --i) ring.push_back(cells * row + i);
  for (int j = cells; j > 0; --j) ring.push_back(j * row);
  std::vector<std::pair<int, int>> cap;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const int p = ring[k], q = ring[(k + 1) % ring.size()];
    const double rise =
        0.5 * (places[static_cast<std::size_t>(p)].second + places[static_cast<std::size_t>(q)].second) - y;
    if ((upper ? rise : -rise) > 0.2 * radius_m) cap.emplace_back(p + 1, q + 1);
  }
  std::string text = fmt::format(
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"cap\"\n2 2 \"{}\"\n$EndPhysicalNames\n$Entities\n"
      "0 1 1 0\n1 0 0 0 1 1 1 1 1 0\n1 0 0 0 1 1 1 1 2 0\n$EndEntities\n$Nodes\n1 {} 1 {}\n2 1 0 {}\n",
      body, row * row, row * row, row * row);
  for (int n = 1; n <= row * row; ++n) text += fmt::format("{}\n", n);
  for (const auto& [px, py] : places) text += fmt::format("{:.17g} {:.17g} 0\n", px, py);
  const auto edges = static_cast<int>(cap.size()), elements = edges + cells * cells;
  text += fmt::format("$EndNodes\n$Elements\n2 {} 1 {}\n1 1 1 {}\n", elements, elements, edges);
  int tag = 0;
  for (const auto& [p, q] : cap) text += fmt::format("{} {} {}\n", ++tag, p, q);
  text += fmt::format("2 1 3 {}\n", cells * cells);
  for (int e = 0; e < cells * cells; ++e) {
    const int n = 1 + e / cells * row + e % cells;
    text += fmt::format("{} {} {} {} {}\n", ++tag, n, n + 1, n + row + 1, n + row);
  }
  return text + "$EndElements\n";
}

struct Discs {
  double apart_m = 0.0, gap_m = 0.0;  ///< of the meshes, and initial_gap_m
  double along_m_s = 0.0;             ///< of each disc across the line of middles
  int lower_cells = 16, upper_cells = 16;
  const char *first = "lower", *second = "upper";

  [[nodiscard]] int windows_of_flight() const {
    return static_cast<int>(std::lround((apart_m + gap_m) / (2.0 * speed_m_s * step_s)));
  }
};

/// Two discs that meet head on, at a velocity that may have a part across.
RunResult collide(const Discs& d, const TemporaryFolder& folder) {
  const double aside = d.along_m_s / speed_m_s * (d.apart_m + d.gap_m);
  (void)folder.write(disc_of("lower", 0.0, -radius_m, d.lower_cells, true), "lower.msh");
  (void)folder.write(disc_of("upper", aside, radius_m + d.apart_m, d.upper_cells, false), "upper.msh");
  std::string text = "model = \"plane_strain\"\n";
  for (const auto& [name, sign] : {std::pair{"lower", 1.0}, std::pair{"upper", -1.0}})
    text += fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 "
        "}}\nmesh = {{ gmsh = \"{}.msh\" }}\ninitial_velocity_m_s = [{}, {}]\n",
        name, name, sign * d.along_m_s, sign * speed_m_s);
  text += fmt::format(
      "[contact]\nsurfaces = [\"{}.cap\", \"{}.cap\"]\ninitial_gap_m = {}\nfriction_coefficient = 0.0\n[time]\n"
      "step_s = {}\nend_s = {:.17g}\n[output]\nhistory_every = 1\n[coupling]\nprotocol = \"all_explicit\"\n",
      d.first, d.second, d.gap_m, step_s, (d.windows_of_flight() + 1100) * step_s);
  return run_text(text, folder);
}

/// By the place of the meshes and by initial_gap_m; but for the first windows, in which discs that touch at the start
/// close at once.
TEST(DiscsThatFly, HaveTheForceOfDiscsThatTouchAtTheStart) {
  constexpr std::size_t first_windows = 20;
  const TemporaryFolder touching_folder;
  const RunResult touching = collide({}, touching_folder);
  const auto& expected = touching.column("contact_force_n");
  const double peak = *std::max_element(expected.begin(), expected.end());
  EXPECT_GT(peak, 1e6);
  for (const Discs& flight : {Discs{.apart_m = 0.1 * radius_m}, Discs{.apart_m = 0.5 * radius_m},
                              Discs{.apart_m = 2.0 * radius_m}, Discs{.gap_m = 0.5 * radius_m}}) {
    const TemporaryFolder folder;
    const RunResult run = collide(flight, folder);
    const auto& force = run.column("contact_force_n");
    const auto flown = static_cast<std::size_t>(flight.windows_of_flight());
    ASSERT_GE(force.size(), flown + expected.size() - 1);
    for (std::size_t i = 0; i + 1 < flown; ++i) ASSERT_EQ(force[i], 0.0) << i;
    for (std::size_t i = first_windows; i + 1 < expected.size(); ++i)
      ASSERT_NEAR(force[flown + i], expected[i], 2e-5 * peak) << flight.apart_m << " " << i;
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  }
}

/// Rows are then written anew a hundred times on the way: the force agrees but for what each of them jumps by.
TEST(DiscsThatFly, ObliquelyHaveTheImpulseAndThePeakOfDiscsThatTouchAtTheStart) {
  const TemporaryFolder touching_folder;
  const RunResult touching = collide({.along_m_s = 5.0}, touching_folder);
  for (const Discs& flight :
       {Discs{.apart_m = 0.1 * radius_m, .along_m_s = 5.0}, Discs{.apart_m = 2.0 * radius_m, .along_m_s = 5.0},
        Discs{.gap_m = 0.5 * radius_m, .along_m_s = 5.0}}) {
    const TemporaryFolder folder;
    const RunResult run = collide(flight, folder);
    EXPECT_NEAR(run.last("contact_impulse_n_s") / touching.last("contact_impulse_n_s"), 1.0, 2e-5);
    EXPECT_NEAR(run.largest("contact_force_n") / touching.largest("contact_force_n"), 1.0, 2e-3);
    EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 6e-3);
    EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  }
}

}  // namespace
}  // namespace ricochet::test
