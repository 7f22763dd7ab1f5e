#include "common/scene/material_library.hpp"

#include <limits>

namespace ricochet::scene {
namespace {

constexpr double none = std::numeric_limits<double>::infinity();
const char* const hibbeler = "Hibbeler";
const char* const dowling = "Dowling; density: Callister";

}  // namespace

const std::vector<LibraryMaterial>& material_library() {
  // E [Pa], nu, rho [kg/m^3], yield stress [Pa], strength [Pa]
  static const std::vector<LibraryMaterial> library{
      {"steel_a36", {200e9, 0.32, 7850.0, 250e6, none}, hibbeler},
      {"stainless_steel_304", {193e9, 0.27, 7860.0, 207e6, none}, hibbeler},
      {"aluminium_6061_t6", {68.9e9, 0.35, 2710.0, 255e6, none}, hibbeler},
      {"aluminium_2014_t6", {73.1e9, 0.35, 2790.0, 414e6, none}, hibbeler},
      {"titanium_ti6al4v", {120e9, 0.36, 4430.0, 924e6, none}, hibbeler},
      {"red_brass_c83400", {101e9, 0.35, 8740.0, 70e6, none}, hibbeler},
      {"bronze_c86100", {103e9, 0.34, 8830.0, 345e6, none}, hibbeler},
      {"cast_iron_gray_20", {67.0e9, 0.28, 7190.0, none, 179e6}, hibbeler},
      {"concrete_high_strength", {29.0e9, 0.15, 2370.0, none, none}, hibbeler},
      {"copper", {130e9, 0.343, 8940.0, none, none}, dowling},
      {"tungsten", {411e9, 0.280, 19300.0, none, none}, dowling},
      {"alumina", {400e9, 0.22, 3980.0, none, none}, dowling},
      {"glass_soda_lime", {69e9, 0.20, 2500.0, none, none}, dowling},
      {"pmma", {2.7e9, 0.35, 1190.0, none, none}, dowling},
  };
  return library;
}

}  // namespace ricochet::scene
