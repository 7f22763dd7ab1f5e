#pragma once

#include <string>

#include "common/body/body_state.hpp"
#include "tests/support/scene_file.hpp"

/// Rods that can be reckoned by hand: elements of 1 m with a stiffness of 8 N/m and 2 kg each, of which either node
/// gets 1 kg; their wave runs at 2 m/s.
namespace ricochet::test {

/// The table [[body]] of a rod; `keys`: more lines of it.
inline std::string rod_body(const std::string& name, int start_m, int elements, const std::string& keys = "") {
  return "[[body]]\nname = \"" + name +
         "\"\nmaterial = { youngs_modulus_pa = 8.0, density_kg_m3 = 2.0 }\nmesh = { start_m = " +
         std::to_string(start_m) + ".0, length_m = " + std::to_string(elements) +
         ".0, elements = " + std::to_string(elements) + " }\n" + keys + "\n";
}

/// A scene of one rod from x = 0 on, explicit.
inline std::string rod(int elements, const std::string& keys = "") {
  return "model = \"bar\"\n" + rod_body("rod", 0, elements, keys) +
         "[time]\nstep_s = 0.1\nend_s = 1.0\n[coupling]\nprotocol = \"all_explicit\"\n";
}

/// A scene of two rods of four elements that touch at x = 0, "left" and "right". Under a hybrid protocol the element of
/// each beside the contact is implicit. `keys`: more lines of the table [contact].
inline std::string two_rods(const std::string& protocol, const std::string& keys = "") {
  const bool hybrid = protocol == "hughes_liu";
  return "model = \"bar\"\n" + rod_body("left", -4, 4) + rod_body("right", 0, 4) +
         "[contact]\nsurfaces = [\"left.end\", \"right.start\"]\n" + keys + "\n" +
         (hybrid ? "[partition]\nimplicit_length_m = { left = 1.0, right = 1.0 }\n" : "") +
         "[time]\nstep_s = 0.1\nend_s = 1.0\n[coupling]\nprotocol = \"" + protocol + "\"\n";
}

/// A scene and the states of one of its participants, by default the first.
struct SceneStates {
  scene::Problem problem;
  const scene::ParticipantSpec& participant;
  std::vector<solver::BodyState> states;

  explicit SceneStates(const std::string& text, const std::string& name = "")
      : problem(build(text)),
        participant(name.empty() ? problem.scene.participants.front() : problem.scene.participant(name)),
        states(solver::initial_states(problem, participant, participant.role == scene::Role::implicit_solver)) {}
  SceneStates(const SceneStates&) = delete;  // the states point into the problem
  SceneStates& operator=(const SceneStates&) = delete;
  ~SceneStates() = default;

 private:
  static scene::Problem build(const std::string& text) {
    const TemporaryFolder folder;
    return scene::build_problem(scene::load_scene(folder.write(text)));
  }
};

}  // namespace ricochet::test
