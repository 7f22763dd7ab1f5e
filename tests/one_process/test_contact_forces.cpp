#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "tests/support/merged_history.hpp"
#include "tests/support/run.hpp"

// A contact force is the impulse over a window, divided by its size. For every contact law, protocol and baseline
// the forces of all windows then add up to the change of momentum of each body, and friction stays in its cone window
// by window.

namespace ricochet {
namespace {

/// Lines of the [contact] table that make a law.
struct Law {
  const char* name;
  const char* keys;
  bool all_explicit;  ///< central difference knows it, too
  bool takes_a_mean_by_impedance = false;
};
constexpr Law laws[] = {
    {"reset", "", true},
    {"massless", "multiplier_update = \"massless\"\n", true},
    {"fully_implicit", "multiplier_update = \"fully_implicit\"\n", false},
    {"penalty", "enforcement = \"penalty\"\npenalty_pa_m = 1e11\n", true},
    {"penalty_mass", "enforcement = \"penalty\"\npenalty_pa_m = 1e13\nimpact_update = \"mass\"\n", false},
    {"penalty_impedance", "enforcement = \"penalty\"\npenalty_pa_m = 1e13\nimpact_update = \"impedance\"\n", false,
     true},
};

struct Protocol {
  const char* name;
  int substeps;
  double momentum_error;  ///< of the protocol itself, relative
};
constexpr Protocol protocols[] = {
    {"hughes_liu", 1, 1e-12},          {"kim", 1, 2e-2},
    {"kim_predicted", 1, 1e-12},       {"belytschko_mullen", 1, 1e-12},
    {"prakash_hjelmstad", 1, 1e-12},   {"prakash_hjelmstad", 2, 1e-12},
    {"gravouil_combescure", 1, 1e-12}, {"gravouil_combescure", 2, 2e-2},
    {"fixed_point", 1, 1e-10},         {"all_implicit", 1, 1e-12},
    {"all_explicit", 1, 1e-12},
};

std::string plate(const char* name, double start_m, double v_t, double v_n, int elements = 10) {
  return std::string("[[body]]\nname = \"") + name +
         "\"\nmaterial = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, " +
         "density_kg_m3 = " + (name[0] == 'l' ? "1000.0" : "1700.0") +
         " }\nmesh = { start_m = " + std::to_string(start_m) + ", length_m = 0.25, height_m = 0.075, elements = [3, " +
         std::to_string(elements) + "], periodic_across = true }\n" + "initial_velocity_m_s = [" + std::to_string(v_t) +
         ", " + std::to_string(v_n) + "]\n";
}

std::string coupled(const Protocol& protocol, double end_s) {
  return "[partition]\nimplicit_length_m = { " + std::string("lower = 0.075") +
         " }\n[time]\nstep_s = 1e-5\nend_s = " + std::to_string(end_s) +
         "\n[coupling]\nresynchronise_every = 10\nprotocol = \"" + protocol.name + "\"\nenergy_growth_limit = 1e9\n" +
         (protocol.substeps > 1 ? "substeps = " + std::to_string(protocol.substeps) + "\n" : std::string());
}

/// One plate against a rigid plane; slides along it at 25 m/s.
std::string on_a_plane(const Law& law, const Protocol& protocol,
                       const char* friction = "friction_coefficient = 0.3\n") {
  return "model = \"plane_strain\"\n" + plate("lower", -0.25, 25.0, 10.0) +
         "[contact]\nsurfaces = [\"lower.end\", \"rigid_plane\"]\n" + friction + law.keys + coupled(protocol, 8e-4);
}

/// Two plates of different density that meet after ten windows; they stick in part of the run, or slip.
std::string two_plates(const Law& law, const Protocol& protocol, double v_t) {
  auto text =
      "model = \"plane_strain\"\n" + plate("lower", -0.25, v_t, 10.0) + plate("upper", 0.0, -v_t, -10.0) +
      "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\ninitial_gap_m = 2e-3\nfriction_coefficient = 0.3\n" +
      law.keys + coupled(protocol, 1e-3);
  return test::replaced(text, "{ lower = 0.075 }", "{ lower = 0.075, upper = 0.05 }");
}

bool applies(const Law& law, const Protocol& protocol) {
  return law.all_explicit || std::string(protocol.name) != "all_explicit";
}

class ContactForce : public testing::TestWithParam<std::tuple<Law, Protocol>> {
 protected:
  std::vector<coupler::HistoryRow> rows(const std::string& text) const {
    const test::TemporaryFolder folder;
    return test::rows_of(folder.write(text));
  }
  const Law& law() const { return std::get<0>(GetParam()); }
  const Protocol& protocol() const { return std::get<1>(GetParam()); }
};

/// Sums of F dt over the rows, one row a window; their largest difference from the cumulative columns.
struct Impulses {
  double normal = 0.0, tangential = 0.0, from_columns = 0.0;

  explicit Impulses(const std::vector<coupler::HistoryRow>& rows) {
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const auto& contact = rows[i].contact;
      const double dt = rows[i].time_s - rows[i - 1].time_s;
      normal += dt * contact.contact_force_n;
      tangential += dt * contact.friction_force_n;
      from_columns = std::max({from_columns, std::abs(normal - contact.contact_impulse_n_s),
                               std::abs(tangential - contact.friction_impulse_n_s)});
    }
  }
};

TEST_P(ContactForce, TimesTheWindowIsTheMomentumThatAPlaneTakes) {
  if (!applies(law(), protocol())) GTEST_SKIP() << "not a law of central difference";
  const auto history = rows(on_a_plane(law(), protocol()));
  const auto &first = history.front().bodies[0], &last = history.back().bodies[0];
  const Impulses sum(history);
  const double momentum = std::hypot(first.momentum_n_kg_m_s, first.momentum_t_kg_m_s),
               allowed = protocol().momentum_error * momentum;
  ASSERT_GT(sum.normal, 0.5 * std::abs(first.momentum_n_kg_m_s)) << "it is to hit the plane";
  EXPECT_NEAR(last.momentum_n_kg_m_s - first.momentum_n_kg_m_s, -sum.normal, allowed);
  EXPECT_NEAR(last.momentum_t_kg_m_s - first.momentum_t_kg_m_s, -sum.tangential, allowed);
  EXPECT_LT(sum.from_columns, 1e-12 * momentum);
}

TEST_P(ContactForce, TimesTheWindowIsTheMomentumThatEachOfTwoBodiesGets) {
  if (!applies(law(), protocol())) GTEST_SKIP() << "not a law of central difference";
  for (const double v_t : {1.0, 20.0}) {
    const auto history = rows(two_plates(law(), protocol(), v_t));
    const Impulses sum(history);
    const auto change = [&](std::size_t body, double BodyTotals::*momentum) {
      return history.back().bodies[body].*momentum - history.front().bodies[body].*momentum;
    };
    const double on_a_n = change(0, &BodyTotals::momentum_n_kg_m_s), on_b_n = change(1, &BodyTotals::momentum_n_kg_m_s);
    const double on_a_t = change(0, &BodyTotals::momentum_t_kg_m_s), on_b_t = change(1, &BodyTotals::momentum_t_kg_m_s);
    const double scale = 18.75 * std::hypot(10.0, v_t), allowed = protocol().momentum_error * scale;
    ASSERT_GT(sum.normal, 0.5 * 18.75 * 10.0) << "they are to hit each other";
    ASSERT_GT(std::abs(sum.tangential), 1.0);
    EXPECT_NEAR(0.5 * (on_b_n - on_a_n), sum.normal, allowed) << v_t;
    EXPECT_NEAR(0.5 * (on_b_t - on_a_t), sum.tangential, allowed) << v_t;
    if (law().takes_a_mean_by_impedance) continue;  // Eq. 25 gives the two bodies different impulses
    EXPECT_NEAR(on_b_n, sum.normal, allowed) << v_t;
    EXPECT_NEAR(on_a_n, -sum.normal, allowed) << v_t;
    EXPECT_NEAR(on_b_t, sum.tangential, allowed) << v_t;
    EXPECT_NEAR(on_a_t, -sum.tangential, allowed) << v_t;
  }
}

TEST_P(ContactForce, OfASlippingPlateIsOnTheConeInEveryWindow) {
  if (!applies(law(), protocol())) GTEST_SKIP() << "not a law of central difference";
  for (const char* friction :
       {"friction_coefficient = 0.3\n", "friction_coefficient = 0.3\nfriction_law = \"regularised\"\n"}) {
    int windows = 0;
    double largest = 0.0, worst = 0.0;
    const auto history = rows(on_a_plane(law(), protocol(), friction));
    for (const auto& row : history) largest = std::max(largest, row.contact.contact_force_n);
    for (const auto& row : history) {
      const double normal = row.contact.contact_force_n;
      if (std::abs(normal) < 1e-9 * largest) continue;
      ++windows;
      worst = std::max(worst, std::abs(std::abs(row.contact.friction_force_n) / normal - 0.3));
      EXPECT_GT(normal, 0.0) << "a contact does not pull";
    }
    EXPECT_GT(windows, 10);
    EXPECT_LT(worst, 1e-12) << friction;
  }
}

/// The plates of `text` as solids as wide as they are high, sliding at an angle to the tangent.
std::string as_solids(std::string text, double angle) {
  text = test::replaced(text, "plane_strain", "solid");
  const std::string mesh = "height_m = 0.075, elements = [3, ", velocity = "initial_velocity_m_s = [";
  for (std::size_t at = 0; (at = text.find(mesh, at)) != std::string::npos;)
    text.replace(at, mesh.size(), "height_m = 0.075, width_m = 0.075, elements = [3, 3, ");
  for (std::size_t at = 0; (at = text.find(velocity, at)) != std::string::npos;) {
    at += velocity.size();
    std::size_t end = 0;
    const double v_t = std::stod(text.substr(at), &end);
    text.replace(at, end, fmt::format("{:.17g}, {:.17g}", v_t * std::cos(angle), v_t * std::sin(angle)));
  }
  return text;
}

/// Periodic plates move along one line, whichever it is: solids have the forces per area of plane strain, on that line.
TEST_P(ContactForce, OfSolidsIsThatOfPlatesAlongAnyTangent) {
  if (!applies(law(), protocol())) GTEST_SKIP() << "not a law of central difference";
  constexpr double angle = 0.5, width_m = 0.075;
  for (const char* friction : {"", "friction_law = \"regularised\"\n"}) {
    // After ten windows exactly it would be round-off that says which pairs have met.
    const auto meeting = test::replaced(two_plates(law(), protocol(), 1.0), "gap_m = 2e-3", "gap_m = 2.1e-3");
    for (const auto& text : {on_a_plane(law(), protocol()), meeting}) {
      const auto scene =
          test::replaced(text, "friction_coefficient = 0.3\n", "friction_coefficient = 0.3\n" + std::string(friction));
      const auto plates = rows(scene), solids = rows(as_solids(scene, angle));
      ASSERT_EQ(plates.size(), solids.size());
      double largest = 0.0, worst = 0.0;
      for (const auto& row : plates) largest = std::max(largest, row.contact.contact_force_n * width_m);
      // Out of the first body n is +z, t = x and n x t = y.
      for (std::size_t i = 0; i < plates.size(); ++i) {
        const auto &flat = plates[i].contact, &solid = solids[i].contact;
        const double along = -flat.friction_force_n * width_m;  // t = -x in the plane
        worst = std::max({worst, std::abs(solid.contact_force_n - flat.contact_force_n * width_m),
                          std::abs(solid.friction_force_n - along * std::cos(angle)),
                          std::abs(solid.friction_force_b_n - along * std::sin(angle))});
        if (flat.contact_iterations >= 30.0) continue;  // it cycled, on the edge of the cone: either word is right
        EXPECT_EQ(solid.pairs_stick, 3.0 * flat.pairs_stick) << "row " << i;
      }
      EXPECT_LT(worst, 1e-9 * largest) << friction;
      EXPECT_NEAR(solids.back().contact.energy_friction_j, plates.back().contact.energy_friction_j * width_m,
                  1e-9 * std::abs(plates.back().contact.energy_friction_j));
    }
  }
}

/// Blocks with free sides, whose pairs slip in directions of their own.
TEST_P(ContactForce, OfSolidBlocksIsTheMomentumOfEachAlongAllThreeDirections) {
  if (!applies(law(), protocol())) GTEST_SKIP() << "not a law of central difference";
  auto text = as_solids(two_plates(law(), protocol(), 6.0), 0.5);
  for (int body = 0; body < 2; ++body) text = test::replaced(text, ", periodic_across = true", "");
  const auto history = rows(text);
  double normal = 0.0, along_t = 0.0, along_b = 0.0;
  for (std::size_t i = 1; i < history.size(); ++i) {
    const auto& contact = history[i].contact;
    const double dt = history[i].time_s - history[i - 1].time_s;
    normal += dt * contact.contact_force_n;
    along_t += dt * contact.friction_force_n;
    along_b += dt * contact.friction_force_b_n;
    if (law().takes_a_mean_by_impedance) continue;
    EXPECT_LE(std::hypot(contact.friction_force_n, contact.friction_force_b_n),
              0.3 * contact.contact_force_n * (1.0 + 1e-12) + 1e-6)
        << i;
  }
  const auto& sums = history.back().contact;
  EXPECT_NEAR(along_t, sums.friction_impulse_n_s, 1e-12 * normal);
  EXPECT_NEAR(along_b, sums.friction_impulse_b_n_s, 1e-12 * normal);
  ASSERT_GT(std::abs(along_b), 0.01 * normal);
  const double allowed = protocol().momentum_error * normal * 2.0;
  const std::tuple<double BodyTotals::*, double> directions[] = {{&BodyTotals::momentum_n_kg_m_s, normal},
                                                                 {&BodyTotals::momentum_t_kg_m_s, along_t},
                                                                 {&BodyTotals::momentum_b_kg_m_s, along_b}};
  for (const auto& [momentum, impulse] : directions) {
    const double on_a = history.back().bodies[0].*momentum - history.front().bodies[0].*momentum,
                 on_b = history.back().bodies[1].*momentum - history.front().bodies[1].*momentum;
    EXPECT_NEAR(0.5 * (on_b - on_a), impulse, allowed);
    if (law().takes_a_mean_by_impedance) continue;  // Eq. 25 gives the two bodies different impulses
    EXPECT_NEAR(on_b, impulse, allowed);
    EXPECT_NEAR(on_a, -impulse, allowed);
  }
}

std::string name_of(const testing::TestParamInfo<std::tuple<Law, Protocol>>& info) {
  const auto& [law, protocol] = info.param;
  return std::string(law.name) + "_" + protocol.name + "_" + std::to_string(protocol.substeps);
}

INSTANTIATE_TEST_SUITE_P(LawsAndProtocols, ContactForce,
                         testing::Combine(testing::ValuesIn(laws), testing::ValuesIn(protocols)), name_of);

}  // namespace
}  // namespace ricochet
