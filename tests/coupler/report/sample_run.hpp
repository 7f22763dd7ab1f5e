#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "common/base/error.hpp"

namespace ricochet::report {

/// The text of a ConfigError that the action throws; empty if it throws none.
template <class Action>
std::string config_error(Action action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

/// Results folder of a made-up run, removed at the end of the test.
class SampleRun : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    write("summary.json", R"({"status": "done", "error": "", "protocol": "hughes_liu", "scene": "scenes/impact.toml",
      "first_contact_s": 1e-6, "separation_time_s": 3e-6, "plateau_stress_pa": 840e6, "energy_error_last": -1e-4,
      "energy_error_lowest": -2e-4, "energy_error_highest": 0, "momentum_error_max": 1e-13, "contact_impulse_n_s": 1.5,
      "contact": {"iterations_mean": 2, "iterations_max": 9, "residual_max": 2e-4, "windows_unconverged": 3}, "version": "0.3.0",
      "theory": {"contact_duration_s": 2e-6, "contact_duration_body": "steel", "contact_stress_pa": 850e6,
      "first_step_s": 2e-6},
      "outside_model": [{"kind": "strain", "text": "strain of 3 % <there>"}], "valid_until_s": 2.5e-6,
      "angular_momentum_error_max": 1e-12, "interface_drift_m": 2e-9,
      "switches": [{"time_s": 3.5e-6, "to": "explicit"}], "processes": [{"name": "coupler", "role": "coupler",
      "wall_s": 1, "compute_s": 0.25, "wait_s": null, "waited_for_s": {"implicit": 0.75}}]})");
    write("history.csv",
          "time_s,gap_min_m,contact_pressure_mean_pa,principal_stress_mean_pa,friction_force_n,velocity_mean_steel_m_s,"
          "velocity_mean_a<b_m_s\n"
          "0,1e-6,0,0,0,30,0\n1e-6,0,3.4e9,5e8,0,29,1\n2e-6,nan,8.4e8,8.5e8,0,10,12\n3e-6,1e-6,0,1e7,0,-5,20\n");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream file(path(name));
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  std::string folder_ = testing::TempDir() + "report_" + std::to_string(getpid());
};

}  // namespace ricochet::report
