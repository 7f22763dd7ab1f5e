// The reader of Gmsh meshes, and the mesh that every model makes of the file.
#include "common/fem/gmsh_file.hpp"
#include "common/fem/mesh.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using ricochet::fem::Model;
  static ricochet::fuzz::MemoryFile file;
  file.hold(ricochet::fuzz::text_of(data, size));
  return ricochet::fuzz::read_or_refuse([] {
    (void)ricochet::fem::read_gmsh_file(file.path());
    for (const auto model : {Model::bar, Model::plane_strain, Model::axisymmetric, Model::solid}) {
      ricochet::fuzz::read_or_refuse([model] {
        const auto mesh = ricochet::fem::read_gmsh(file.path(), model, "body");
        ricochet::fem::check_mesh(mesh, "body");
      });
    }
  });
}
