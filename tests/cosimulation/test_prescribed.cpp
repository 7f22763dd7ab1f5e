#include <algorithm>

#include "tests/support/run.hpp"

// One end of two bars in contact is pushed at V for 0.4 s and then held: a pulse of the force Z V = rho c A V runs
// through both of them, unchanged, until it is at the far end at 1 s. Momentum Z V t and work Z V^2 t, half of it
// kinetic.

namespace ricochet::test {
namespace {

constexpr double velocity_m_s = 0.01, push_s = 0.4, impedance = 4.0;  // E = 4, rho = 1, A = 2: c = 2

struct Method {
  const char* name;
  const char* coupling;
};

const char* const implicit_there = "{ left = 1.0, right = 0.1 }";  // all of the bar that is pushed
const char* const explicit_there = "{ left = 0.1, right = 0.1 }";
const char* const explicit_tip = "{ left = 0.99, right = 0.1 }";  // the pushed node is a neighbour of the shared one

std::string pushed_bars(const Method& method, const std::string& implicit_length) {
  std::string text = "model = \"bar\"\n";
  for (const std::string body : {"left", "right"}) {
    text += "[[body]]\nname = \"" + body +
            "\"\nmaterial = { youngs_modulus_pa = 4.0, density_kg_m3 = 1.0 }\narea_m2 = 2.0\n";
    text +=
        std::string("mesh = { start_m = ") + (body == "left" ? "-1.0" : "0.0") + ", length_m = 1.0, elements = 100 }\n";
    if (body == "left")
      text +=
          "prescribed = [{ surface = \"start\", component = \"x\", displacement_m = 0.004, "
          "amplitude = { time_s = [0.0, 0.4], factor = [0.0, 1.0] } }]\n";
  }
  return text +
         "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n[partition]\nimplicit_length_m = " + implicit_length +
         "\n[time]\nsafety_factor = 0.9\nend_s = 0.8\n[coupling]\n" + method.coupling;
}

class Prescribed : public testing::TestWithParam<std::tuple<Method, const char*>> {};

TEST_P(Prescribed, MotionSendsThePulseOfTheoryThroughBothBars) {
  const TemporaryFolder folder;
  const auto& [method, implicit_length] = GetParam();
  const RunResult run = run_text(pushed_bars(method, implicit_length), folder);
  const double force = impedance * velocity_m_s;
  EXPECT_NEAR(run.mean("contact_force_n", 0.55, 0.8), force, 0.015 * force)
      << "from 0.5 s on; measured: 1.1 % with two substeps";
  EXPECT_LT(run.mean("contact_force_n", 0.0, 0.4), 1e-3 * force) << "the pulse is not there yet";
  EXPECT_NEAR(run.last("momentum_n_kg_m_s"), force * push_s, 0.01 * force * push_s);
  const double work = force * velocity_m_s * push_s;
  EXPECT_NEAR(run.last("energy_external_j"), work, 0.02 * work);
  EXPECT_NEAR(run.last("energy_kinetic_j"), 0.5 * work, 0.02 * work);
  EXPECT_NEAR(run.last("energy_strain_j"), 0.5 * work, 0.02 * work);
  double unowned = 0.0;  // kinetic + strain - external - contact - interface, beyond the pushed node's 1/2 m V^2
  for (std::size_t i = 0; i < run.column("time_s").size(); ++i) {
    const auto value = [&](const char* term) { return run.column(std::string("energy_") + term + "_j")[i]; };
    unowned = std::max(unowned, std::abs(value("kinetic") + value("strain") - value("external") - value("contact") -
                                         value("interface") - 0.5 * 0.01 * velocity_m_s * velocity_m_s));
  }
  EXPECT_LT(unowned, 1e-3 * work)
      << "the trapezoidal rule takes a kink of what is given for less than it is, at one node";
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), std::string(method.name) == "kim" ? 0.1 : 1e-9);
}

INSTANTIATE_TEST_SUITE_P(
    Methods, Prescribed,
    testing::Combine(
        testing::Values(Method{"hughes_liu", "protocol = \"hughes_liu\"\n"}, Method{"kim", "protocol = \"kim\"\n"},
                        Method{"belytschko_mullen", "protocol = \"belytschko_mullen\"\n"},
                        Method{"fixed_point", "protocol = \"fixed_point\"\n"},
                        Method{"prakash_hjelmstad", "protocol = \"prakash_hjelmstad\"\nsubsteps = 2\n"},
                        Method{"gravouil_combescure", "protocol = \"gravouil_combescure\"\nsubsteps = 1\n"},
                        Method{"all_implicit", "protocol = \"all_implicit\"\n"},
                        Method{"all_explicit", "protocol = \"all_explicit\"\n"}),
        testing::Values(implicit_there, explicit_there, explicit_tip)),
    [](const auto& test) {
      const char* length = std::get<1>(test.param);
      return std::string(std::get<0>(test.param).name) + (length == implicit_there   ? "_implicit_there"
                                                          : length == explicit_there ? "_explicit_there"
                                                                                     : "_explicit_tip");
    });

}  // namespace
}  // namespace ricochet::test
