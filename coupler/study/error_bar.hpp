#pragma once

#include <map>
#include <optional>
#include <string>

namespace ricochet::coupler {

/// One quantity as the runs of an error estimate have it [its unit]; empty: that run has no such value, and `missing`
/// may say why, by the names below.
struct QuantityLevels {
  double run = 0.0;                                       ///< mesh h, step Dt
  std::optional<double> coarse{}, coarsest{};             ///< 2h and 2 Dt; 4h and 4 Dt
  std::optional<double> coarse_mesh{};                    ///< 2h, Dt
  std::optional<double> coarse_baseline{}, coarse_law{};  ///< 2h and 2 Dt, all_implicit; the other contact law
  std::optional<double> double_step{}, half_step{};       ///< h: where the mesh cannot be coarsened
  bool hybrid = true;                                     ///< no coupling has no error
  double floor = 0.0;                                     ///< the bar is never below it: three windows, of times
  std::map<std::string, std::string> missing{};           ///< by the names of the parts
};

/// How far the run's value may be from that of an endlessly fine mesh and step [unit of the quantity]. Empty: unknown,
/// and `unknown` says why, by the names "total", "time", "space", "coupling", "contact_law".
struct ErrorBar {
  std::optional<double> total, time, space, coupling, contact_law;
  std::optional<double> order;  ///< observed; empty: none to be seen
  std::string found;            ///< how: "converging", "not converging", "time alone" or "unknown"
  std::map<std::string, std::string> unknown;
};

/// With Q1, Q2, Q4 of the levels h, 2h, 4h (step in proportion), d1 = Q1 - Q2 and d2 = Q2 - Q4: where d1 d2 > 0 and the
/// observed order log2(d2/d1) is within [1/2, 2], the bar is 2 |d1|/(2^p - 1) with p that order, but 1 at most: impacts
/// are of first order, whatever a smooth problem has (form of Roache's grid convergence index, 1994). Elsewhere it is
/// |d1| + |d2|, and 1.5 times that where d1 d2 > 0 and the order is lower. Time and space are what the two changes of
/// d1 make one after the other, so they may cancel; coupling and contact law are differences on the level 2h, reduced
/// by 2^-p.
[[nodiscard]] ErrorBar error_bar(const QuantityLevels& levels);

}  // namespace ricochet::coupler
