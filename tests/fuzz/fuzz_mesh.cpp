// The readers of Gmsh meshes and of Abaqus input files, and the mesh that every model makes of the file.
#include "common/fem/gmsh_file.hpp"
#include "common/fem/inp_file.hpp"
#include "common/fem/mesh.hpp"
#include "tests/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using ricochet::fem::Model;
  static ricochet::fuzz::MemoryFile file;
  file.hold(ricochet::fuzz::text_of(data, size));
  if (size > 0 && data[0] == '*') {  // no section of a Gmsh file begins so
    return ricochet::fuzz::read_or_refuse([] {
      (void)ricochet::fem::ignored_inp_cards(file.path());
      for (const auto model : {Model::bar, Model::plane_strain, Model::axisymmetric, Model::solid}) {
        ricochet::fuzz::read_or_refuse([model] {
          const auto mesh = ricochet::fem::read_inp(file.path(), model, "body", true);
          ricochet::fem::check_mesh(mesh, "body");
        });
      }
    });
  }
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
