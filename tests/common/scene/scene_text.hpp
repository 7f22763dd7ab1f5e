#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "common/scene/scene.hpp"

/// Scenes written out as text: what the tests of this folder start from.
namespace ricochet::scene {

/// A folder of this test's own, removed with it.
class SceneFolder {
 public:
  SceneFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "ricochet_scene_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp");
    path_ = pattern;
  }
  SceneFolder(const SceneFolder&) = delete;
  SceneFolder& operator=(const SceneFolder&) = delete;
  ~SceneFolder() { std::filesystem::remove_all(path_); }

  std::string write(const std::string& text, const std::string& name = "scene.toml") const {
    const std::string file = (path_ / name).string();
    std::ofstream(file) << text;
    return file;
  }

 private:
  std::filesystem::path path_;
};

inline Scene load_text(const std::string& text) {
  const SceneFolder folder;
  return load_scene(folder.write(text));
}

/// `text` with its one `from` replaced.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t place = text.find(from);
  if (place == std::string::npos) throw std::invalid_argument("not in the scene: " + from);
  return text.replace(place, from.size(), to);
}

/// Two cylinders, 4 x 8 elements of 1 mm x 2.5 mm and 1 mm x 2.5 mm, in touch at z = 0. Lines are counted from 1.
inline const std::string cylinders = R"(model = "axisymmetric"
[[body]]
name = "steel"
material = { youngs_modulus_pa = 207e9, poisson_ratio = 0.3, density_kg_m3 = 7860.0 }
mesh = { start_m = -0.02, length_m = 0.02, radius_m = 0.004, elements = [4, 8] }
initial_velocity_m_s = [0.0, 30.0]
[[body]]
name = "carbide"
material = { youngs_modulus_pa = 626.8e9, poisson_ratio = 0.207, density_kg_m3 = 14900.0 }
mesh = { length_m = 0.02, radius_m = 0.004, elements = [4, 8] }
[contact]
surfaces = ["steel.end", "carbide.start"]
friction_coefficient = 0.1
[partition]
implicit_length_m = { steel = 0.005, carbide = 0.0075 }
[time]
step_s = 1e-7
end_s = 1e-5
[coupling]
protocol = "hughes_liu"
[output]
fields_every = 0
)";

/// Two equal bars of 20 elements with a gap, as in the two-bar impact of Carpenter, Taylor and Katona.
inline const std::string bars = R"(model = "bar"
[[body]]
name = "left"
material = { youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }
area_m2 = 6.4516e-4
mesh = { start_m = -0.254, length_m = 0.254, elements = 20 }
initial_velocity_m_s = [5.13588]
[[body]]
name = "right"
material = { youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }
area_m2 = 6.4516e-4
mesh = { start_m = 0.508e-3, length_m = 0.254, elements = 20 }
initial_velocity_m_s = [-5.13588]
[contact]
surfaces = ["left.end", "right.start"]
[partition]
implicit_length_m = { left = 0.0635, right = 0.0635 }
[time]
step_s = 2.226e-6
end_s = 200e-6
)";

/// The same with what is behind the middle of the left bar foreign.
inline const std::string joined_bars = R"(model = "bar"
[[body]]
name = "tail"
foreign = true
joined_to = "left"
surface = "start"
mass_kg = 0.64
[[body]]
name = "left"
material = { youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }
area_m2 = 6.4516e-4
mesh = { start_m = -0.127, length_m = 0.127, elements = 10 }
initial_velocity_m_s = [5.13588]
[[body]]
name = "right"
material = { youngs_modulus_pa = 206.8e9, density_kg_m3 = 7844.066 }
area_m2 = 6.4516e-4
mesh = { start_m = 0.508e-3, length_m = 0.254, elements = 20 }
initial_velocity_m_s = [-5.13588]
[contact]
surfaces = ["left.end", "right.start"]
[partition]
implicit_length_m = { left = 0.0635, right = 0.0635 }
[time]
step_s = 2.226e-6
end_s = 200e-6
[[participant]]
name = "explicit"
role = "explicit"
bodies = ["left", "right"]
[[participant]]
name = "far"
role = "explicit"
bodies = ["tail"]
executable = "./far"
[[participant]]
name = "implicit"
role = "implicit"
)";

/// Two plane-strain plates, 4 x 6 elements, thickness 0.5 m.
inline const std::string plates = R"(model = "plane_strain"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.3, length_m = 0.3, height_m = 0.2, elements = [4, 6] }
thickness_m = 0.5
[[body]]
name = "upper"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.3, height_m = 0.2, elements = [4, 6] }
thickness_m = 0.5
[contact]
surfaces = ["lower.end", "upper.start"]
[partition]
implicit_length_m = { lower = 0.1, upper = 0.05 }
[time]
step_s = 1e-5
end_s = 1e-3
)";

/// Two solid blocks, 2 x 3 x 6 elements, 0.2 m x 0.3 m across.
inline const std::string blocks = R"(model = "solid"
[[body]]
name = "lower"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { start_m = -0.3, length_m = 0.3, height_m = 0.2, width_m = 0.3, elements = [2, 3, 6] }
[[body]]
name = "upper"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 0.3, height_m = 0.2, width_m = 0.3, elements = [2, 3, 6] }
[contact]
surfaces = ["lower.end", "upper.start"]
[partition]
implicit_length_m = { lower = 0.1, upper = 0.05 }
[time]
step_s = 1e-5
end_s = 1e-3
)";

}  // namespace ricochet::scene
