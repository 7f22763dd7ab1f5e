#include "tests/support/places.hpp"

namespace ricochet::test {

const std::string& source_folder() {
  static const std::string folder = RICOCHET_SOURCE;
  return folder;
}

const std::string& build_folder() {
  static const std::string folder = RICOCHET_BUILD;
  return folder;
}

}  // namespace ricochet::test
