#include "tests/bench/thread_rows.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "tests/bench/reference_scene.hpp"

namespace ricochet::bench {
namespace {

std::string participant(const std::string& protocol, int threads) {
  const bool implicit = protocol == "all_implicit";
  return fmt::format("[[participant]]\nname = \"alone\"\nrole = \"{}\"\n{}threads = {}\n",
                     implicit ? "implicit" : "explicit", implicit ? "" : "bodies = [\"steel\", \"carbide\"]\n",
                     threads);
}

}  // namespace

void ThreadRuns::repeat() {
  const std::string folder = folder_ + "/threads";
  std::filesystem::create_directories(folder);
  for (const int refinement : refinements_) {
    for (const std::string protocol : {"all_implicit", "all_explicit"}) {
      for (const int threads : {1, 2}) {
        SceneChoice choice;
        choice.refinement = refinement;
        choice.protocol = protocol;
        choice.steps = steps_;
        choice.participants = participant(protocol, threads);
        const auto scene = write_reference_scene(choice, folder + "/scene.toml");
        window_s_[{protocol, refinement, threads}].push_back(run_scene(scene, 1, folder + "/run").window_s);
      }
    }
  }
}

std::vector<Row> ThreadRuns::rows() const {
  std::vector<Row> rows;
  for (const auto& [choice, time_s] : window_s_) {
    if (choice.threads != 1) continue;
    rows.push_back({choice.protocol + ", stepping: one thread / two",
                    mesh_name(choice.refinement),
                    quotients(time_s, window_s_.at({choice.protocol, choice.refinement, 2})),
                    {}});
  }
  return rows;
}

}  // namespace ricochet::bench
