#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/base64.hpp"
#include "common/solver/shape_recorder.hpp"
#include "tests/common/scene/scene_text.hpp"
#include "tests/support/rods.hpp"

namespace ricochet::solver {
namespace {

using testing::DoubleNear;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Json = nlohmann::json;

template <class Number>
std::vector<Number> numbers(const Json& packed) {
  const auto bytes = from_base64(packed.get<std::string>()).value();
  std::vector<Number> values(bytes.size() / sizeof(Number));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

/// A recorder of a scene's first participant, or of the named one, and what it leaves.
struct Recorded {
  explicit Recorded(const std::string& text, const std::string& name = "") : scene(text, name) {
    setup.clock = 0.1;
    setup.output_directory = folder.path().string();
  }
  [[nodiscard]] std::unique_ptr<ShapeRecorder> recorder(PressedSurface pressing = {}) const {
    return std::make_unique<ShapeRecorder>(scene.problem, scene.states, setup, "mine", pressing);
  }
  [[nodiscard]] std::string path() const { return (folder.path() / "mine.shapes.json").string(); }
  [[nodiscard]] Json file() const { return Json::parse(std::ifstream(path())); }
  /// Every node's displacement as a function of its place.
  void displace(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& u) {
    for (auto& state : scene.states) {
      const int components = fem::components(state.part.mesh.model);
      for (int node = 0; node < state.part.nodes(); ++node) {
        const Eigen::Vector3d value = u(state.part.mesh.position[static_cast<std::size_t>(node)]);
        for (int c = 0; c < components; ++c) state.u[node * components + c] = value[c];
      }
    }
  }

  test::SceneStates scene;
  test::TemporaryFolder folder;
  participant::Setup setup;
};

TEST(ShapeRecorder, KeepsDisplacementsAndTheStressOfEachBar) {
  Recorded run(test::two_rods("hughes_liu"), "implicit");
  auto recorder = run.recorder();
  recorder->note(0);
  run.displace([](const Eigen::Vector3d& x) { return Eigen::Vector3d(0.25 + 0.5 * x[0] * x[0], 0, 0); });
  recorder->finish(7);
  const auto file = run.file();
  EXPECT_EQ(file["format"], "ricochet shapes 2");
  EXPECT_EQ(file["model"], "bar");
  EXPECT_EQ(file["windows"], Json({0, 7}));
  EXPECT_EQ(file["largest_window_s"], 0.1);
  EXPECT_EQ(file["times_s"], Json({0.0, 7 * 0.1}));
  EXPECT_EQ(file["nose"], false);
  EXPECT_EQ(file["uneven"], false);
  ASSERT_EQ(file["bodies"].size(), 2U);
  const auto& left = file["bodies"][0];
  EXPECT_EQ(left["name"], "left");
  EXPECT_EQ(left["strip_m"], 1.0);
  EXPECT_THAT(numbers<int>(left["node"]), ElementsAre(3, 4)) << "its own node numbers are those of the body";
  EXPECT_THAT(numbers<float>(left["position_m"]), ElementsAre(-1.0F, 0.0F));
  EXPECT_THAT(numbers<int>(left["cell"]), ElementsAre(0, 1, -1, -1));
  EXPECT_THAT(numbers<float>(left["displacement_m"][0]), ElementsAre(0.0F, 0.0F));
  EXPECT_THAT(numbers<float>(left["displacement_m"][1]), ElementsAre(0.75F, 0.25F));
  EXPECT_THAT(numbers<float>(left["stress_pa"][1]), ElementsAre(-4.0F)) << "E = 8 Pa, strain -1/2";
  EXPECT_THAT(numbers<float>(file["bodies"][1]["stress_pa"][1]), ElementsAre(4.0F));
}

TEST(ShapeRecorder, KeepsEvenlySpacedWindowsHoweverManyComeAndTheLast) {
  for (const auto& [last, kept] : {std::pair<int, Json>{5, {0, 1, 2, 3, 4, 5}},
                                   {8, {0, 2, 4, 6, 8}},
                                   {17, {0, 4, 8, 12, 16, 17}},
                                   {1000, {0, 128, 256, 384, 512, 640, 768, 896, 1000}}}) {
    Recorded run(test::rod(2));
    auto recorder = run.recorder();
    for (int window = 0; window <= last; ++window) {
      run.displace([&](const Eigen::Vector3d&) { return Eigen::Vector3d(window, 0, 0); });
      recorder->note(window);
      if (window == 0) recorder->note(window);  // synchronised twice
    }
    recorder->finish(last);
    const auto file = run.file();
    ASSERT_EQ(file["windows"], kept);
    for (std::size_t i = 0; i < kept.size(); ++i) {
      EXPECT_THAT(numbers<float>(file["bodies"][0]["displacement_m"][i]), Each(kept[i].get<float>())) << last;
    }
  }
}

TEST(ShapeRecorder, KeepsMoreWindowsWhileBodiesTouch) {
  for (const auto& [end, kept] : {std::pair<int, Json>{500, {0, 128, 256, 384, 500, 512, 640, 768, 896, 1000}},
                                  {502, {0, 128, 256, 384, 500, 501, 502, 512, 640, 768, 896, 1000}},
                                  {600, {0, 128, 256, 384, 500, 512, 532, 564, 596, 640, 768, 896, 1000}},
                                  {512, {0, 128, 256, 384, 500, 504, 508, 512, 640, 768, 896, 1000}}}) {
    Recorded run(test::rod(2));
    auto recorder = run.recorder();
    for (int window = 0; window <= 1000; ++window) {
      run.displace([&](const Eigen::Vector3d&) { return Eigen::Vector3d(window, 0, 0); });
      if (window > 0) recorder->note_touch(window >= 500 && window <= end);
      recorder->note(window);
    }
    recorder->finish(1000);
    const auto file = run.file();
    ASSERT_EQ(file["windows"], kept) << end;
    for (std::size_t i = 0; i < kept.size(); ++i)
      EXPECT_THAT(numbers<float>(file["bodies"][0]["displacement_m"][i]), Each(kept[i].get<float>())) << end;
  }
}

// Uniaxial tension of 1e9 Pa * 1e-3 in z, with the contraction that leaves the sides free.
TEST(ShapeRecorder, OfSolidsKeepsTheSurfaceWithItsVonMisesStress) {
  Recorded run(scene::blocks + "[coupling]\nprotocol = \"all_explicit\"\n");
  auto recorder = run.recorder();
  run.displace([](const Eigen::Vector3d& x) { return Eigen::Vector3d(-0.25e-3 * x[0], -0.25e-3 * x[1], 1e-3 * x[2]); });
  recorder->finish(1);
  const Json body = run.file()["bodies"][1];
  const auto cells = numbers<int>(body["cell"]);
  EXPECT_EQ(cells.size(), 4U * 2 * (2 * 3 + 2 * 6 + 3 * 6));
  EXPECT_THAT(cells, Each(testing::Ge(0)));
  EXPECT_EQ(numbers<int>(body["node"]).size(), 3U * 4 * 7 - 1 * 2 * 5) << "but for the nodes inside";
  const auto stress = numbers<float>(body["stress_pa"][0]);
  EXPECT_EQ(stress.size(), cells.size() / 4);
  EXPECT_THAT(stress, Each(testing::FloatNear(1e6F, 1.0F)));
}

TEST(ShapeRecorder, OfABodyThatYieldsKeepsItsPlasticStrain) {
  const std::string material = "density_kg_m3 = 1000.0 }";
  Recorded run(test::replaced(scene::blocks, material,
                              "density_kg_m3 = 1000.0, plasticity = { yield_stress_pa = 1e3, hardening_pa = 1e9 } }") +
               "[coupling]\nprotocol = \"all_explicit\"\n");
  run.scene.states[0].plastic->equivalent.setConstant(0.125);
  run.recorder()->finish(1);
  const Json bodies = run.file()["bodies"];
  const auto strain = numbers<float>(bodies[0]["plastic_strain"][0]);
  EXPECT_EQ(strain.size(), numbers<int>(bodies[0]["cell"]).size() / 4);
  EXPECT_THAT(strain, Each(0.125F));
  EXPECT_FALSE(bodies[1].contains("plastic_strain")) << "it is elastic";
  EXPECT_FALSE(bodies[0].contains("temperature_rise_k")) << "nothing heats it";
}

TEST(ShapeRecorder, OfABodyThatIsHeatedKeepsTheRiseOfItsTemperature) {
  Recorded run(test::replaced(scene::blocks, "density_kg_m3 = 1000.0 }",
                              "density_kg_m3 = 1000.0, plasticity = { yield_stress_pa = 1e3, hardening_pa = 1e9, "
                              "heat = { specific_heat_j_kg_k = 500.0, reference_k = 300.0 } } }") +
               "[coupling]\nprotocol = \"all_explicit\"\n");
  run.scene.states[0].plastic->equivalent.setConstant(0.125);
  run.scene.states[0].plastic->temperature_k.setConstant(320.0);
  run.recorder()->finish(1);
  const Json bodies = run.file()["bodies"];
  const auto rise = numbers<float>(bodies[0]["temperature_rise_k"][0]);
  EXPECT_EQ(rise.size(), numbers<int>(bodies[0]["cell"]).size() / 4);
  EXPECT_THAT(rise, Each(20.0F));
  EXPECT_THAT(numbers<float>(bodies[0]["plastic_strain"][0]), Each(0.125F));
  EXPECT_FALSE(bodies[1].contains("temperature_rise_k")) << "it is elastic";
}

// Two blocks of 2 x 3 faces that press each other evenly: on both surfaces, and nowhere else.
TEST(ShapeRecorder, OfWhoEnforcesTheContactKeepsItsPressureOnBothSurfaces) {
  Recorded run(scene::blocks + "[coupling]\nprotocol = \"all_explicit\"\n");
  const ContactSurface surface(run.scene.problem, run.scene.states);
  std::vector<PairForce> forces(surface.pairs.size());
  auto recorder = run.recorder({&surface, &forces, &run.scene.states});
  recorder->note(0);
  for (std::size_t i = 0; i < forces.size(); ++i) forces[i].normal = 2e6 * surface.pairs[i].area_m2;
  recorder->finish(1);
  const Json bodies = run.file()["bodies"];
  for (const auto& body : bodies) {
    EXPECT_THAT(numbers<float>(body["contact_pressure_pa"][0]), Each(0.0F));
    const auto pressure = numbers<float>(body["contact_pressure_pa"][1]);
    EXPECT_EQ(pressure.size(), numbers<int>(body["cell"]).size() / 4);
    EXPECT_EQ(std::count_if(pressure.begin(), pressure.end(), [](float pa) { return pa > 0.0F; }), 6) << body["name"];
    EXPECT_FLOAT_EQ(*std::max_element(pressure.begin(), pressure.end()), 2e6F);
  }
}

TEST(ShapeRecorder, WhereAMeshRepeatsDrawsTheImageOfANode) {
  const std::string plates = R"(model = "plane_strain"
[[body]]
name = "plate"
material = { youngs_modulus_pa = 1e9, poisson_ratio = 0.25, density_kg_m3 = 1000.0 }
mesh = { length_m = 2.0, height_m = 3.0, elements = [3, 2], periodic_across = true }
initial_velocity_m_s = [1.0, -2.0]
[coupling]
protocol = "all_explicit"
[time]
step_s = 1e-5
end_s = 1e-3
)";
  Recorded run(plates);
  run.recorder()->finish(0);
  const Json body = run.file()["bodies"][0];
  const auto nodes = numbers<int>(body["node"]);
  EXPECT_EQ(nodes.size(), 12U);
  EXPECT_EQ(std::count_if(nodes.begin(), nodes.end(), [](int node) { return node < 0; }), 3);
  const auto x = numbers<float>(body["position_m"]);
  const auto cells = numbers<int>(body["cell"]);
  for (std::size_t c = 0; c < cells.size(); c += 4) {
    float low = 10, high = -10;
    for (std::size_t i = c; i < c + 4; ++i) {
      low = std::min(low, x[2 * static_cast<std::size_t>(cells[i])]);
      high = std::max(high, x[2 * static_cast<std::size_t>(cells[i])]);
    }
    EXPECT_FLOAT_EQ(high - low, 1.0F) << "no element reaches across the whole mesh";
  }
  EXPECT_EQ(body["initial_velocity_m_s"], Json({1, -2, 0}));
}

TEST(ShapeRecorder, OfARunThatFailsLeavesWhatWasKept) {
  const Recorded run(test::rod(2));
  auto recorder = run.recorder();
  recorder->note(0);
  recorder->note(1);
  EXPECT_FALSE(std::filesystem::exists(run.path())) << "nothing is written while the run goes on";
  recorder.reset();
  EXPECT_EQ(run.file()["windows"], Json({0, 1}));
}

TEST(ShapeRecorder, WritesNothingWhereNobodyWantsIt) {
  Recorded run(test::rod(2));
  run.recorder().reset();
  EXPECT_FALSE(std::filesystem::exists(run.path())) << "nothing was kept";
  run.setup.output_directory = "";
  auto none = run.recorder();
  none->note(0);
  none->finish(1);
  EXPECT_FALSE(std::filesystem::exists("mine.shapes.json"));
  run.setup.output_directory = (run.folder.path() / "elsewhere").string();
  testing::internal::CaptureStderr();
  run.recorder()->finish(1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "a folder of another machine";
  EXPECT_FALSE(std::filesystem::exists(run.setup.output_directory));
}

TEST(ShapeRecorder, AFileThatCannotBeWrittenCostsThePictureAlone) {
  const Recorded run(test::rod(2));
  std::filesystem::create_directories(run.path() + "/occupied");
  testing::internal::CaptureStderr();
  EXPECT_NO_THROW(run.recorder()->finish(1));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              testing::AllOf(HasSubstr("mine: no picture of its elements in report.html: "), HasSubstr(run.path())));
}

TEST(ShapeRecorder, OfTooManyElementsTellsTheirNumberOnly) {
  Recorded run(test::rod(100001));
  auto recorder = run.recorder();
  recorder->note(0);
  recorder->finish(1);
  EXPECT_EQ(run.file()["too_many_cells"], 100001);
  EXPECT_THAT(run.file()["bodies"], IsEmpty());
}

}  // namespace
}  // namespace ricochet::solver
