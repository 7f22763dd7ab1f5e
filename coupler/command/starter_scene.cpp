#include "coupler/command/starter_scene.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::coupler {
namespace {

constexpr const char* text =
    R"(# Two cylinders meet end to end at 30 m/s. SI units; every key is described in docs/scene.md.
#   ricochet check {0}    what the run would be, without starting anything
#   ricochet run {0}      runs it; results in out/{1}

model = "axisymmetric"  # "bar" | "plane_strain" | "axisymmetric" (coordinates r, z)

[[body]]
name = "striker"
material = {{ youngs_modulus_pa = 206.8e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }}
# Structured mesh along z from start_m; elements = [across, along]. Or: mesh = {{ gmsh = "striker.msh" }}
mesh = {{ start_m = -80e-3, length_m = 80e-3, radius_m = 5e-3, elements = [5, 80] }}
initial_velocity_m_s = [0.0, 30.0]

[[body]]
name = "target"
material = {{ youngs_modulus_pa = 206.8e9, poisson_ratio = 0.3, density_kg_m3 = 7850.0 }}
mesh = {{ start_m = 0.0, length_m = 80e-3, radius_m = 5e-3, elements = [5, 80] }}
initial_velocity_m_s = [0.0, 0.0]

[contact]
surfaces = ["striker.end", "target.start"]  # or ["striker.end", "rigid_plane"]
initial_gap_m = 0.0
friction_coefficient = 0.1                  # 0 or left out: no friction, no tangential unknowns

[partition]
# These lengths next to the contact are implicit, the rest is explicit.
implicit_length_m = {{ striker = 10e-3, target = 10e-3 }}

[time]
safety_factor = 0.9            # of the critical step of the explicit elements; or: step_s = 1e-7
end_s = 60e-6                  # the latest end
until_separated_plus_s = 2e-6  # ends earlier if the bodies have separated

[coupling]
protocol = "hughes_liu"        # "kim" | "kim_predicted" | "all_implicit" | "all_explicit"
transport = "auto"             # shared memory on this machine, ZeroMQ where that cannot be | "shm" | "zmq" | "tcp"

[output]
history_every = 1              # windows per row of history.csv
fields_every = 50              # windows per ParaView snapshot; 0: none
axial_stress_every = 5         # windows per row of axial_stress.csv, the x-t diagram of the report; 0: none
)";

}  // namespace

std::string write_starter_scene(const std::string& name) {
  std::filesystem::path path = name;
  if (path.extension() != ".toml") path += ".toml";
  std::error_code no_status;  // of a name that no file can have: writing it says so
  if (std::filesystem::exists(path, no_status)) {
    throw ConfigError(fmt::format("{} exists already; give another name or remove it first", path.string()));
  }
  write_atomically(path.string(), fmt::format(fmt::runtime(text), path.string(), path.stem().string()));
  return path.string();
}

}  // namespace ricochet::coupler
