// The SDK as a package: a project of its own finds it, builds against it and takes part in a run.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <regex>

#include "tests/support/run.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
const std::string project = RICOCHET_SOURCE "/tests/support/spring_mass_project";

#ifdef __SANITIZE_ADDRESS__
constexpr const char* sanitizers = "-fsanitize=address,undefined";  // as in the libraries that are installed
#else
constexpr const char* sanitizers = "";
#endif

/// The SDK installed, and the project built against it.
struct Package {
  TemporaryFolder folder;
  std::string prefix = (folder.path() / "prefix").string(), build = (folder.path() / "build").string();
  std::string program = build + "/spring_mass";

  Package() {
    run({"cmake", "--install", RICOCHET_BUILD, "--prefix", prefix, "--component", "sdk"});
    run({"cmake", "-S", project, "-B", build, "-G", "Ninja", "-DCMAKE_PREFIX_PATH=" + prefix,
         fmt::format("-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror {}", sanitizers)});
    run({"cmake", "--build", build});
  }
  void run(std::vector<std::string> command) const {
    command.insert(command.begin(), "/usr/bin/env");
    const auto outcome = run_command(command, folder.path().string(), 300.0);
    if (outcome.code == 0) return;
    throw std::runtime_error(fmt::format("{}\n{}{}", fmt::join(command, " "), outcome.out, outcome.error));
  }
};

void takes_part_in_a_run(const Package& package) {
  TemporaryFolder folder;
  const std::string scene = config_text("two_bars") +
                            fmt::format(
                                "[[participant]]\nname = \"spring\"\nrole = \"explicit\"\nbodies = [\"left\"]\n"
                                "executable = \"{}\"\ndiffering_bodies = [\"left\"]\n",
                                package.program) +
                            "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"right\"]\n"
                            "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
  const auto run = run_text(scene, folder);
  EXPECT_LT(run.summary.at("momentum_error_max").get<double>(), 1e-12);
  EXPECT_NEAR(run.mean("contact_force_n", 55e-6, 72e-6), 1.33453e5, 0.05 * 1.33453e5);  // before its end is felt
}

void keeps_the_contract(const Package& package) {
  const auto outcome = run_command({ricochet_binary(), "check-participant", "--", package.program, "--name", "spring"},
                                   package.folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.error;
  EXPECT_THAT(outcome.out, testing::HasSubstr("0 failed"));
}

TEST(SpringMassExample, IsUnderEightyLines) {
  const std::string text = file_text(project + "/spring_mass.cpp");
  EXPECT_GT(text.size(), 0U);
  EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 80);
}

void headers_include_nothing_that_is_not_installed(const Package& package) {
  const std::regex line("#include \"([^\"]+)\"");
  int headers = 0;
  for (const auto& entry : fs::recursive_directory_iterator(package.prefix + "/include")) {
    if (entry.path().extension() != ".hpp") continue;
    ++headers;
    const std::string text = file_text(entry.path().string());
    EXPECT_EQ(text.find("Eigen"), text.find("Eigen nor"));
    for (std::sregex_iterator found(text.begin(), text.end(), line), end; found != end; ++found) {
      EXPECT_TRUE(fs::exists(package.prefix + "/include/ricochet/" + (*found)[1].str())) << (*found)[1];
    }
  }
  EXPECT_EQ(headers, 4);
}

void python_participant_runs_from_its_place(const Package& package) {
  const auto outcome = run_command({package.prefix + "/share/ricochet/python/explicit_bar.py", "--help"},
                                   package.folder.path().string());
  EXPECT_EQ(outcome.code, 0) << outcome.error;
  EXPECT_THAT(outcome.out, testing::HasSubstr("--connect"));
}

void command_line_errors_name_what_is_wrong(const Package& package) {
  const auto says = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), package.program);
    const auto outcome = run_command(arguments, package.folder.path().string());
    EXPECT_EQ(outcome.code, 2);
    return outcome.error;
  };
  EXPECT_THAT(says({"--conect", "x"}),
              testing::HasSubstr("unexpected argument \"--conect\", allowed are --scene, --name, "
                                 "--connect, --key, --watch-stdin; did you mean \"--connect\"?"));
  EXPECT_THAT(says({"--name"}), testing::HasSubstr("--name needs a value"));
  EXPECT_THAT(says({"--name", "a"}), testing::HasSubstr("--connect is missing"));
  EXPECT_THAT(says({"--name", "a", "--connect", "nowhere"}), testing::HasSubstr("cannot connect to 'nowhere'"));
}

/// One test: each would have to install and build anew.
TEST(Package, IsFoundBuiltAgainstAndRun) {
  const Package package;
  takes_part_in_a_run(package);
  keeps_the_contract(package);
  headers_include_nothing_that_is_not_installed(package);
  python_participant_runs_from_its_place(package);
  command_line_errors_name_what_is_wrong(package);
}

}  // namespace
}  // namespace ricochet::test
