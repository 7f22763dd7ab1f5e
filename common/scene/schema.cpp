#include "common/scene/schema.hpp"

namespace ricochet::scene {

const Schema& scene_schema() {
  static const Schema tables{
      {"scene",
       {"model", "material", "body", "contact", "partition", "time", "coupling", "participant", "output", "checkpoint",
        "mass_scaling", "accuracy"}},
      {"body",
       {"name", "material", "mesh", "area_m2", "thickness_m", "initial_velocity_m_s", "initial_displacement_m",
        "large_rotation", "initial_angular_velocity_rad_s", "gravity_m_s2", "support", "traction", "prescribed",
        "absorbing", "foreign", "joined_to", "surface", "interface_nodes", "mass_kg"}},
      {"material",
       {"youngs_modulus_pa", "poisson_ratio", "density_kg_m3", "yield_stress_pa", "strength_pa", "plasticity"}},
      {"plasticity",
       {"yield_stress_pa", "hardening_pa", "hardening_exponent", "rate_factor", "reference_rate_per_s", "heat"}},
      {"heat", {"specific_heat_j_kg_k", "work_fraction", "reference_k", "melting_k", "softening_exponent"}},
      {"mesh",
       {"length_m", "radius_m", "height_m", "width_m", "elements", "start_m", "grading", "periodic_across", "gmsh",
        "inp", "length_unit", "refine", "place"}},
      {"place", {"turned_deg", "about_m", "moved_m"}},
      {"refine", {"from_m", "to_m", "ratio"}},
      {"initial_displacement_m", {"start", "end"}},
      {"support", {"surface", "at_m", "fixed"}},
      {"traction", {"surface", "traction_pa", "pressure_pa", "amplitude"}},
      {"prescribed", {"surface", "component", "displacement_m", "amplitude"}},
      {"amplitude", {"time_s", "factor"}},
      {"absorbing", {"surface", "wave"}},
      {"contact",
       {"name", "surfaces", "normal", "rigid_radius_m", "rigid_axis", "rigid_place_m", "initial_gap_m", "nose_radius_m",
        "enforcement", "multiplier_update", "penalty_pa_m", "impact_update", "friction_coefficient", "friction_law",
        "friction_regularisation_s_m"}},
      {"partition", {"implicit_length_m", "implicit_groups", "rule", "reduced_modes"}},
      {"time", {"step_s", "largest_step_s", "safety_factor", "changes", "end_s", "until_separated_plus_s"}},
      {"changes", {"from_s", "step_s"}},
      {"coupling",
       {"protocol", "substeps", "acceleration", "relaxation", "tolerance", "max_iterations", "resynchronise_every",
        "after_separation", "separation_windows", "timeout_s", "start_timeout_s", "launcher", "transport", "address",
        "port", "energy_growth_limit", "energy_loss_limit", "outside_model"}},
      {"participant",
       {"name", "role", "bodies", "groups", "executable", "differing_bodies", "start", "launch", "ranks", "threads",
        "substeps"}},
      {"mass_scaling", {"step_s"}},
      {"accuracy", {"relative_error"}},
      {"output",
       {"history_every", "history_every_s", "fields_every", "fields_every_s", "axial_stress_every", "probes_every",
        "probes_every_s", "probe", "gauge"}},
      {"probe", {"name", "body", "at_m"}},
      {"gauge", {"name", "body", "section_m", "length_m", "surface", "rise_time_s"}},
      {"checkpoint", {"every_windows", "every_s", "on_failure", "attempts"}},
  };
  return tables;
}

}  // namespace ricochet::scene
