#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/problem/problem.hpp"
#include "coupler/report/parts/history_table.hpp"

/// How far a run is from a reference, quantity by quantity.
namespace ricochet::coupler {

/// A history, linear between its points and constant outside them. Two points at one time are a jump.
struct Curve {
  std::vector<double> time_s, value;
  [[nodiscard]] double at(double time_s) const;
};

/// The numbers of one contact, or of all together.
struct ContactObservation {
  Curve contact_pressure_pa;                ///< mean over closed pairs, positive in compression
  Curve contact_force_n, friction_force_n;  ///< sums over all pairs; forces and pressure are means over windows
  Curve friction_force_b_n;                 ///< of solids
  double contact_begin_s = 0.0, contact_end_s = 0.0;  ///< of the windows of first and last force; equal: there was none
  std::optional<double> peak_force_n, separation_time_s;
};

/// Answers of a run, or of an exact solution, for the quantities of interest: of all contacts, and of each of several.
struct Observation : ContactObservation {
  Curve principal_stress_pa;  ///< mean over the contact surface, positive in compression
  std::map<std::string, ContactObservation> contacts;
  std::map<std::string, Curve> probes;  ///< by columns of probes.csv
  std::optional<double> energy_drift;
  std::vector<double> rebound_velocity_m_s;  ///< mean velocity of every body along the normal, at the end
  double greatest_speed_m_s = 0.0;           ///< of these mean velocities, at any time
};

/// `probes`: probes.csv, empty of a run without.
[[nodiscard]] Observation observe(const report::HistoryTable& history, const nlohmann::ordered_json& summary,
                                  const report::HistoryTable& probes = {});

/// One-dimensional impedance theory (theory.hpp) as an observation. ConfigError where it is not exact: for other models
/// than bars, with supports or loads, and where the longer bar's wave changes the force before the end.
[[nodiscard]] Observation exact_impact(const scene::Problem& problem);

/// The properties of a scene that the quantities go by that a study of it may ask for.
struct MeasuredScene {
  bool solid = false;
  std::vector<std::string> contacts{};  ///< names of several
  std::vector<std::string> probes{};    ///< columns of probes and gauges
};

/// Names of the quantities of a whole scene, as a study file lists them:
///   contact_force, principal_stress  RMS over the reference's contact period of the difference of the histories,
///     over the reference's plateau: its mean from 15 % to 65 % of that period (principal stress: Eq. 29)
///   friction_force  the same of the friction force, over the plateau of the reference's contact force; of solids
///     friction_force_b, too, along the binormal
///   peak_force  relative;  separation_time  over the reference's contact period
///   rebound_velocity  largest difference of any body over the reference's greatest speed
///   energy_drift  of the run itself, over the initial energy, whatever the reference.
[[nodiscard]] std::vector<std::string> quantity_names(const MeasuredScene& scene);
/// And of each of several contacts, "QUANTITY/CONTACT"; of probes and gauges "probe/COLUMN": RMS over all of the
/// reference's rows of the difference of the histories, over the reference's largest magnitude.
[[nodiscard]] std::vector<std::string> more_quantity_names(const MeasuredScene& scene);

/// Quantities that are histories of a stress.
[[nodiscard]] std::vector<std::string> history_names(const MeasuredScene& scene);
[[nodiscard]] const Curve& history_of(const std::string& quantity, const Observation& of);

/// RMS over the contact period of `of` of the difference of two histories [their unit], which over a stress is Eq. 29
/// of the paper with N large. Empty without contact.
[[nodiscard]] std::optional<double> rms_difference(const Curve& run, const Curve& reference,
                                                   const ContactObservation& of);
/// The same of a quantity that is a history, over the contact period of the other.
[[nodiscard]] std::optional<double> rms_difference(const std::string& quantity, const Observation& run,
                                                   const Observation& other);

/// Empty where the run or the reference has no such value.
[[nodiscard]] std::optional<double> error_of(const std::string& quantity, const Observation& run,
                                             const Observation& reference);

}  // namespace ricochet::coupler
