// Participants that compute with several threads: the same bytes for any number of them.
#include <fmt/format.h>

#include "tests/support/same_results.hpp"

namespace ricochet::test {
namespace {

struct Case {
  std::string protocol, text, bodies;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.protocol; }

/// Two cylinders of so many elements that a factor has several subtrees, and that the waves of contact soon reach rows
/// for several threads. One is implicit in the half at the contact, the other in a thin layer.
std::string cylinders(const std::string& protocol) {
  const std::string coarse = "elements = [10, 160]", fine = "elements = [40, 160]";
  const std::string text = with_key(replaced(replaced(config_text("kim_impact"), coarse, fine), coarse, fine),
                                    "partition", "implicit_length_m", "{ steel = 0.04, carbide = 0.0011 }");
  const std::string shorter = with_key(with_key(text, "time", "step_s", "1.2e-8"), "time", "end_s", "1.44e-6");
  return with_protocol_of_two_steps(
      with_key(with_key(shorter, "output", "fields_every", "40"), "output", "axial_stress_every", "7"), protocol);
}

/// The same of solids.
std::string blocks(const std::string& protocol) {
  const auto block = [](const char* name, double start_m, double velocity_m_s) {
    return fmt::format(R"([[body]]
name = "{}"
material = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 }}
mesh = {{ start_m = {}, length_m = 0.018, height_m = 0.009, width_m = 0.009, elements = [9, 9, 18] }}
initial_velocity_m_s = [0.0, 0.0, {:.1f}]
)",
                       name, start_m, velocity_m_s);
  };
  const std::string text = "model = \"solid\"\n" + block("lower", -0.018, 1.0) + block("upper", 0.0, -1.0) +
                           R"([contact]
surfaces = ["lower.end", "upper.start"]
friction_coefficient = 0.3
[partition]
implicit_length_m = { lower = 0.0121, upper = 0.0011 }
[time]
step_s = 1e-7
end_s = 3e-6
[output]
fields_every = 10
axial_stress_every = 3
)";
  return with_protocol_of_two_steps(text, protocol);
}

/// Where they touch their elements are half as large and take two steps in one.
std::string with_small_steps() {
  const std::string lower = "start_m = -0.018,", upper = "start_m = 0,";
  const auto refined = [](const char* from, const char* to, const std::string& mesh) {
    return fmt::format("refine = [{{ from_m = [0.0, 0.0, {}], to_m = [0.009, 0.009, {}], ratio = 2 }}], {}", from, to,
                       mesh);
  };
  const std::string text = with_key(blocks("local_explicit"), "time", "step_s", "1.6e-7");
  return replaced(replaced(text, lower, refined("-0.003", "0.0", lower)), upper, refined("0.0", "0.003", upper));
}

std::string with_threads(const Case& c, int threads) {
  std::string text = c.text;
  if (!c.protocol.ends_with("_explicit"))
    text += fmt::format("[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\nthreads = {}\n", threads);
  return text + fmt::format("[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [{}]\nthreads = {}\n",
                            c.bodies, threads);
}

class AnyNumberOfThreads : public testing::TestWithParam<Case> {};

TEST_P(AnyNumberOfThreads, GivesTheSameBytes) {
  const TemporaryFolder folder;
  const RunResult alone = run_text(with_threads(GetParam(), 1), folder);
  EXPECT_GT(alone.largest("contact_force_n"), 0.0);
  for (const int threads : {2, 7}) {
    const TemporaryFolder other;
    const RunResult run = run_text(with_threads(GetParam(), threads), other);
    expect_same_results(run.folder, alone.folder, {"scene", "scene_sha256"});  // in which the numbers stand
  }
}

std::string name_of_case(const testing::TestParamInfo<Case>& test) { return test.param.protocol; }

std::vector<Case> of(std::string (*scene)(const std::string&), const std::string& bodies) {
  std::vector<Case> cases;
  for (const std::string protocol : {"hughes_liu", "prakash_hjelmstad", "all_implicit", "all_explicit"})
    cases.push_back({protocol, scene(protocol), bodies});
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Cylinders, AnyNumberOfThreads, testing::ValuesIn(of(cylinders, R"("steel", "carbide")")),
                         name_of_case);
INSTANTIATE_TEST_SUITE_P(BlocksWithSmallSteps, AnyNumberOfThreads,
                         testing::Values(Case{"local_explicit", with_small_steps(), R"("lower", "upper")"}),
                         name_of_case);
INSTANTIATE_TEST_SUITE_P(Blocks, AnyNumberOfThreads, testing::ValuesIn(of(blocks, R"("lower", "upper")")),
                         name_of_case);

}  // namespace
}  // namespace ricochet::test
