// configs/rounded_striker.toml: a mesh so fine at the contact that all-explicit needs 23 times the steps of the hybrid.
// The peak force, up to its time, against a run of the whole structure by the trapezoidal rule with short steps.
#include <gmock/gmock.h>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

using testing::HasSubstr;

struct Method {
  std::string protocol, step_s, substeps;
};

std::string scene_text(const Method& method) {
  std::string text = with_protocol(config_text("rounded_striker"), method.protocol);
  const std::string mesh = "gmsh = \"";
  for (std::size_t at = text.find(mesh); at != std::string::npos; at = text.find(mesh, at + mesh.size()))
    text.insert(at + mesh.size(), source_folder() + "/configs/");
  text = with_key(text, "time", "step_s", method.step_s);
  text = with_key(text, "time", "end_s", "26e-6");
  text = with_key(text, "output", "fields_every", "0");
  return method.substeps.empty() ? text : with_key(text, "coupling", "substeps", method.substeps);
}

double peak_force_n(const Method& method) {
  const TemporaryFolder folder;
  const RunResult run = run_text(scene_text(method), folder);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-10);
  EXPECT_LT(run.summary.at("energy_error_max").get<double>(), 4e-3);
  return run.summary.at("peak_contact_force_n");
}

TEST(RoundedStriker, PeakForceOfTheHybridIsThatOfAFineImplicitRun) {
  const double fine = peak_force_n({"all_implicit", "8e-9", ""});
  const auto error = [fine](const Method& method) { return std::abs(peak_force_n(method) / fine - 1.0); };
  EXPECT_LT(error({"hughes_liu", "8e-9", ""}), 0.0007);
  EXPECT_LT(error({"hughes_liu", "4e-8", ""}), 0.0031);
  EXPECT_LT(error({"hughes_liu", "6e-8", ""}), 0.0031) << "its 388 shared nodes are left out of the dense root";
  EXPECT_LT(error({"prakash_hjelmstad", "6.4e-7", "16"}), 0.0011)
      << "the setting of the benchmark; a force is the mean of a window";
}

TEST(RoundedStriker, AllExplicitCannotTakeTheHybridsStep) {
  const TemporaryFolder folder;
  const auto check = [&folder](const Method& method) {
    return run_command({ricochet_binary(), "check", folder.write(scene_text(method), "scene.toml")},
                       folder.path().string());
  };
  EXPECT_EQ(check({"all_explicit", "1.7e-9", ""}).code, 0);
  const auto refused = check({"all_explicit", "4e-8", ""});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.error, HasSubstr("22.38 times the critical time step"));
}

}  // namespace
}  // namespace ricochet::test
