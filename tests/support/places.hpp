#pragma once

#include <string>

/// Where the tests find what they read and start. Functions of one small source, not macros: a compiler cache can keep
/// all else for a checkout in another folder.
namespace ricochet::test {

/// The checkout's folder.
const std::string& source_folder();

/// The folder of the build that the test program belongs to.
const std::string& build_folder();

}  // namespace ricochet::test
