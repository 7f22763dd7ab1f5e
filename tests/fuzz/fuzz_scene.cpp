// The reader of scene files, and what follows from a scene that it accepts, if that is small.
#include <algorithm>
#include <variant>

#include "common/problem/problem.hpp"
#include "common/scene/scene.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

/// An honest scene of millions of elements takes its time and memory, which `check` tells; here it would hide what
/// takes too much.
bool is_small(const ricochet::scene::Scene& scene) {
  constexpr double most_elements = 200;
  return std::all_of(scene.bodies.begin(), scene.bodies.end(), [](const auto& body) {
    return std::all_of(body.pieces.begin(), body.pieces.end(), [](const auto& piece) {
      const auto* mesh = std::get_if<ricochet::scene::StructuredMesh>(&piece.elements);
      return mesh != nullptr &&
             1.0 * mesh->elements_along * std::max(1, mesh->elements_across) * std::max(1, mesh->elements_wide) <=
                 most_elements;
    });
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static ricochet::fuzz::MemoryFile file;
  file.hold(ricochet::fuzz::text_of(data, size));
  return ricochet::fuzz::read_or_refuse([] {
    const auto scene = ricochet::scene::load_scene(file.path());
    if (is_small(scene)) (void)ricochet::scene::build_problem(scene);
  });
}
