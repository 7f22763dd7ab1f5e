// An implicit solver that nobody here wrote: GetFEM assembles, common/participant/python/getfem_impact.py takes part.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

const std::string getfem = source_folder() + "/common/participant/python/getfem_impact.py";

/// The first 200 windows of the paper's impact without friction; `executable` for the implicit side, empty for ours.
std::string short_impact(const std::string& protocol, const std::string& executable) {
  std::string text = with_protocol(config_text("kim_impact"), protocol);
  text = replaced(text, "friction_coefficient = 0.1\n", "");
  text = replaced(text, "until_separated_plus_s = 10e-6\n", "");
  text = with_key(text, "time", "end_s", "10.8e-6");
  text = replaced(text, "fields_every = 50", "fields_every = 0");
  return text + "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"steel\", \"carbide\"]\n" +
         "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n" +
         (executable.empty() ? "" : fmt::format("executable = \"{}\"\n", executable));
}

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

class GetfemImpact : public testing::TestWithParam<const char*> {};

/// The same elements, quadrature, lumping and integrator: what is left is the order of the sums.
TEST_P(GetfemImpact, AgreesWithOurImplicitSolverToRoundOff) {
  TemporaryFolder folder;
  const auto theirs = run_text(short_impact(GetParam(), getfem), folder, "getfem");
  const auto ours = run_text(short_impact(GetParam(), ""), folder, "ours");
  ASSERT_EQ(ours.column("time_s").size(), 201U);
  ASSERT_EQ(theirs.column("time_s"), ours.column("time_s"));
  for (const char* name : {"contact_force_n", "contact_pressure_mean_pa", "contact_impulse_n_s", "pairs_slip",
                           "pairs_open", "energy_kinetic_j", "energy_strain_j", "momentum_n_kg_m_s",
                           "velocity_mean_steel_m_s", "velocity_mean_carbide_m_s"}) {
    const auto &a = theirs.column(name), &b = ours.column(name);
    double difference = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) difference = std::max(difference, std::abs(a[i] - b[i]));
    EXPECT_LE(difference, 1e-10 * largest(b)) << name;
    RecordProperty(name, fmt::format("{}", difference / std::max(largest(b), 1e-300)));
  }
  EXPECT_EQ(largest(ours.column("pairs_slip")), 11.0);  // they did touch
}

INSTANTIATE_TEST_SUITE_P(Protocols, GetfemImpact, testing::Values("hughes_liu", "kim"),
                         [](const auto& test) { return std::string(test.param); });

TEST(Getfem, KeepsTheContract) {
  TemporaryFolder folder;
  const auto scene = folder.write(short_impact("hughes_liu", ""));
  const auto outcome =
      run_command({ricochet_binary(), "check-participant", "--", getfem, "--scene", scene, "--name", "implicit"},
                  folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
}

/// With contact, and beside ours.
TEST(Getfem, ComputesWhatOurImplicitSolverDoes) {
  TemporaryFolder folder;
  const auto scene = folder.write(short_impact("hughes_liu", getfem));
  const auto outcome = run_command({ricochet_binary(), "check-participant", "--scene", scene, "--name", "implicit"},
                                   folder.path().string(), 120.0);
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  EXPECT_THAT(outcome.out, testing::HasSubstr("passed   computes what the shipped solver does: window "));
}

/// A contact owner that finds its forces, but says of every second window that it did not.
std::string doubting_participant(const TemporaryFolder& folder) {
  const auto path = folder.write(fmt::format(R"(#!/usr/bin/python3
import sys
sys.path.insert(0, "{}/common/participant/python")
import getfem, getfem_impact
from ricochet_participant import main


class Doubting(getfem_impact.Impact):
    rows = -1

    def describe(self):
        description = super().describe()
        description.record_columns += ["contact_iterations", "contact_residual", "contact_unconverged"]
        return description

    def synchronise(self, integration, link):
        self.rows = -1  # the start may be synchronised more than once
        return super().synchronise(integration, link)

    def record(self):
        self.rows += 1
        return super().record() + [30 if self.rows else 0, 2e-5 if self.rows else 0, self.rows // 2]


getfem.util_trace_level(0)
main(Doubting)
)",
                                             source_folder()),
                                 "doubting.py");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

TEST(Getfem, ContactForcesThatWereNotFoundAreTold) {
  TemporaryFolder folder;
  const auto run = run_text(short_impact("hughes_liu", doubting_participant(folder)), folder);
  const std::string told =
      "100 windows whose contact forces were not found to 1e-6 of the largest one; worst residual 2e-05";
  EXPECT_THAT(run.outcome.error, testing::HasSubstr("warning: "));
  EXPECT_THAT(run.outcome.error, testing::HasSubstr(told));
  EXPECT_THAT(run.outcome.out, testing::HasSubstr(told));
  EXPECT_EQ(run.summary["contact"]["windows_unconverged"], 100);
  EXPECT_DOUBLE_EQ(run.summary["contact"]["iterations_mean"], 30.0);
  EXPECT_THAT(file_text(run.folder + "/report.html"), testing::HasSubstr("100; worst residual 2e-05"));
  EXPECT_THAT(file_text(run.folder + "/trace.json"), testing::HasSubstr(R"("args": {"iterations": 30})"));
  const double impulse = run.summary["contact_impulse_n_s"];
  double sum = 0.0;
  for (const double force : run.column("contact_force_n")) sum += 5.4e-8 * force;
  EXPECT_NEAR(impulse, sum, 1e-12 * sum);
}

/// Contact and all: what GetFEM's matrices make is the same in another process.
TEST(Getfem, GoesOnFromWhatItSaved) {
  TemporaryFolder folder;
  const auto whole =
      run_text(with_key(short_impact("hughes_liu", getfem), "checkpoint", "every_windows", "60"), folder, "whole");
  const auto half = (folder.path() / "half").string();
  std::filesystem::copy(whole.folder, half, std::filesystem::copy_options::recursive);
  std::filesystem::remove(fmt::format("{}/checkpoint/{}.json", half, checkpoints_in(half).back()));
  const auto outcome = resume(half, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.error;
  expect_same_results(half, whole.folder);
}

TEST(Getfem, RefusesFriction) {
  TemporaryFolder folder;
  const auto scene = replaced(short_impact("hughes_liu", getfem), "\"carbide.start\"]",
                              "\"carbide.start\"]\nfriction_coefficient = 0.1");
  const auto run = run_file(folder.write(scene), folder);
  EXPECT_EQ(run.outcome.code, 4);
  EXPECT_THAT(run.outcome.error, testing::HasSubstr("knows contact of two surfaces without friction"));
}

}  // namespace
}  // namespace ricochet::test
