// The SDK as a package: a project of its own finds it, builds against it and takes part in a run.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>
#include <regex>
#include <sstream>

#include "tests/support/places.hpp"
#include "tests/support/run.hpp"
#include "tests/support/same_history.hpp"

namespace ricochet::test {
namespace {

namespace fs = std::filesystem;
const std::string project = source_folder() + "/tests/support/spring_mass_project";

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
    run({"cmake", "--install", build_folder(), "--prefix", prefix, "--component", "sdk"});
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

/// A compiler's command with what links the shared library.
std::vector<std::string> linked(const Package& package, std::vector<std::string> command) {
  std::istringstream words(sanitizers);
  for (std::string word; words >> word;) command.push_back(word);
  for (const auto& entry : fs::recursive_directory_iterator(package.prefix)) {
    if (entry.path().filename() != "libricochet.so") continue;
    const auto folder = entry.path().parent_path().string();
    command.insert(command.end(), {"-L" + folder, "-Wl,-rpath," + folder, "-lricochet"});
  }
  return command;
}

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
  EXPECT_EQ(headers, 5);
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
                                 "--connect, --key, --critical-step, --watch-stdin; did you mean \"--connect\"?"));
  EXPECT_THAT(says({"--name"}), testing::HasSubstr("--name needs a value"));
  EXPECT_THAT(says({"--name", "a"}), testing::HasSubstr("--connect is missing"));
  EXPECT_THAT(says({"--name", "a", "--connect", "nowhere"}), testing::HasSubstr("cannot connect to 'nowhere'"));
}

/// One participant of the left bar, in Fortran, on the C face.
void fortran_participant_takes_part_in_runs(const Package& package) {
  const auto include = package.prefix + "/include/ricochet", bar = (package.folder.path() / "explicit_bar").string();
  const std::vector<std::string> command{"gfortran",
                                         "-O2",
                                         "-Wall",
                                         "-Werror",
                                         "-J",
                                         package.folder.path(),
                                         "-o",
                                         bar,
                                         include + "/ricochet.f90",
                                         source_folder() + "/common/participant/c/explicit_bar.f90"};
  package.run(linked(package, command));
  for (const auto& [protocol, substeps] : {std::pair{"kim", 1}, {"belytschko_mullen", 1}, {"prakash_hjelmstad", 3}}) {
    TemporaryFolder folder;
    const auto scene = [&, protocol = protocol, substeps = substeps](const std::string& executable) {
      auto text = with_protocol(config_text("two_bars"), protocol);
      if (substeps > 1) text = with_key(text, "coupling", "substeps", std::to_string(substeps));
      text =
          with_key(text, "time", "changes", "[{ from_s = 80e-6, step_s = 1e-6 }, { from_s = 110e-6, step_s = 2e-6 }]");
      return text + "[[participant]]\nname = \"bar\"\nrole = \"explicit\"\nbodies = [\"left\"]\n" + executable +
             "[[participant]]\nname = \"explicit\"\nrole = \"explicit\"\nbodies = [\"right\"]\n"
             "[[participant]]\nname = \"implicit\"\nrole = \"implicit\"\n";
    };
    const auto fortran = run_text(scene(fmt::format("executable = \"{}\"\n", bar)), folder, "fortran");
    expect_same_history(fortran, run_text(scene(""), folder, "ours"), 1e-11);
    EXPECT_GT(fortran.largest("contact_force_n"), 1e5);
  }
  const auto contract =
      run_command({ricochet_binary(), "check-participant", "--", bar, "--name", "bar"}, package.folder.path().string());
  EXPECT_EQ(contract.code, 0) << contract.out << contract.error;
}

/// The implicit participant of a rod of two elements, of which one is its own, held at its far end: the trapezoidal
/// rule for the one free node, with the summed mass.
const char* implicit_in_c = R"(#include <ricochet.h>

int main(void) {
  const double k = 4e5, dt8 = 1.0 / 8;
  const char* columns[] = {"energy_kinetic_j/rod", "energy_strain_j/rod", "energy_interface_j/rod",
                           "momentum_n_kg_m_s/rod", "impulse_n_kg_m_s/rod", "mass_kg/rod"};
  double u = 0, v = 0.1, a = 0, m = 2, l = 0, work = 0, impulse = 0, share = 0, first_share = 0, row[6] = {0};
  const double position = 10.0, own_mass = 1.0;
  const int body = 0;
  ricochet_loop* loop = ricochet_open("implicit", "implicit.c", 1);
  if (!loop) return 2;
  int error = ricochet_add_body(loop, "rod") | ricochet_set_interface(loop, 1, &body, &position, &own_mass);
  for (int i = 0; i < 6; ++i) error |= ricochet_add_column(loop, columns[i]);
  if (error) return error;
  if ((error = ricochet_initialize(loop, &u, row))) return error;
  if (!ricochet_driven_by_force(loop)) return 5;
  if ((error = ricochet_interface_mass(loop, &m))) return error;
  const double window = ricochet_window_size(loop);
  while (ricochet_ongoing(loop)) {
    const double dt = ricochet_max_time_step(loop), u_old = u, l_old = l, a_old = a;
    if ((error = ricochet_read(loop, &l))) return error;
    const double predicted = u + dt * v + dt * dt / 4 * a;
    a = (-l - k * predicted) / (m + dt * dt / 4 * k);
    u = predicted + dt * dt / 4 * a;
    v += dt / 2 * (a_old + a);
    work -= 0.5 * (l_old + l) * (u - u_old);
    impulse -= dt / 2 * k * (u_old + u);
    share = dt8 * window * window * a * l;
    if (dt == 0) first_share = share;
    row[0] = 0.5 * m * v * v + share;
    row[1] = 0.5 * k * u * u;
    row[2] = work + share - first_share;
    row[3] = m * v;
    row[4] = impulse;
    row[5] = m + own_mass;
    if ((error = ricochet_write(loop, &u, &v, &a, row))) return error;
    if ((error = ricochet_advance(loop))) return error;
  }
  return ricochet_close(loop);
}
)";

void implicit_participant_in_c_takes_part_in_a_run(const Package& package) {
  const auto& folder = package.folder;
  const auto program = (folder.path() / "implicit").string();
  package.run(linked(package, {"cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
                               folder.write(implicit_in_c, "implicit.c"), "-o", program,
                               "-I" + package.prefix + "/include/ricochet"}));
  static_cast<void>(folder.write(R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
0 1 "start"
0 2 "end"
1 3 "rod"
1 4 "left"
$EndPhysicalNames
$Entities
2 2 0 0
1 0 0 0 1 1
2 20 0 0 1 2
1 0 0 0 10 0 0 2 3 4 2 1 -2
2 10 0 0 20 0 0 1 3 2 1 -2
$EndEntities
$Nodes
1 3 1 3
1 1 0 3
1
2
3
0 0 0
10 0 0
20 0 0
$EndNodes
$Elements
4 4 1 4
0 1 15 1
1 1
0 2 15 1
2 3
1 1 1 1
3 1 2
1 2 1 1
4 2 3
$EndElements
)",
                                 "rod.msh"));
  const auto scene = [](const std::string& executable) {
    return R"(model = "bar"
[[body]]
name = "rod"
mesh = { gmsh = "rod.msh" }
material = { youngs_modulus_pa = 4e6, density_kg_m3 = 0.2 }
support = [{ surface = "start", fixed = ["x"] }, { surface = "end", fixed = ["x"] }]
initial_velocity_m_s = [0.1]
[partition]
implicit_groups = { rod = ["left"] }
[time]
step_s = 5e-4
end_s = 0.1
[[participant]]
name = "explicit"
role = "explicit"
bodies = ["rod"]
[[participant]]
name = "implicit"
role = "implicit"
)" + executable;
  };
  const auto c = run_text(scene("executable = \"" + program + "\"\n"), folder, "c");
  expect_same_history(c, run_text(scene(""), folder, "ours"), 1e-11);
  EXPECT_GT(c.largest("energy_strain_j"), 0.009);  // of 0.01 J
}

/// Masses at three nodes and nothing else, beside a body of which it knows no mesh. Its set-up takes 4 s and says so;
/// it prints what the coupler tells it.
const char* lump_in_c = R"(#define _POSIX_C_SOURCE 200112L
#include <ricochet.h>
#include <stdio.h>
#include <time.h>

int main(void) {
  const double mass[] = {1, 2, 1}, position[] = {0, -0.04, 0.01, -0.04, 0.02, -0.04}, zero[6] = {0};
  const int body[3] = {0};
  const struct timespec half_a_second = {0, 500000000};
  double n_t[4], place[6];
  ricochet_loop* loop = ricochet_open("explicit", "lump.c", 2);
  if (!loop) return 2;
  int error = ricochet_add_body(loop, "tail") | ricochet_set_interface(loop, 3, body, position, mass);
  if (error || (error = ricochet_initialize(loop, zero, zero))) return error;
  for (int i = 0; i < 8; ++i) {
    nanosleep(&half_a_second, NULL);
    if ((error = ricochet_progress(loop, "casting", i / 8.0))) return error;
  }
  if ((error = ricochet_directions(loop, n_t) | ricochet_scene_position(loop, place))) return error;
  for (int i = 0; i < 4; ++i) printf("%.15g ", n_t[i]);
  for (int i = 0; i < 6; ++i) printf("%.15g ", place[i]);
  fflush(stdout);
  while (ricochet_ongoing(loop)) {
    if (ricochet_progress(loop, "casting", 1) != 2) return 9;
    if ((error = ricochet_write(loop, zero, NULL, NULL, zero) | ricochet_advance(loop))) return error;
  }
  return ricochet_close(loop);
}
)";

/// The same, without a pause.
const char* lump_in_fortran = R"f90(program lump
  use, intrinsic :: iso_c_binding
  use ricochet
  implicit none
  real(c_double) :: n_t(2, 2), place(2, 3), zero(6) = 0
  type(c_ptr) :: loop
  integer :: error
  loop = ricochet_open("explicit" // c_null_char, "lump.f90" // c_null_char, 2_c_int)
  if (.not. c_associated(loop)) call exit(2)
  error = ricochet_add_body(loop, "tail" // c_null_char)
  error = ricochet_set_interface(loop, 3_c_int, [0_c_int, 0_c_int, 0_c_int], &
                                 [0d0, -0.04d0, 0.01d0, -0.04d0, 0.02d0, -0.04d0], [1d0, 2d0, 1d0])
  if (error == 0) error = ricochet_initialize(loop, zero, zero)
  if (error == 0) error = ricochet_progress(loop, "casting" // c_null_char, 0.5d0)
  if (error == 0) error = ricochet_directions(loop, n_t)
  if (error == 0) error = ricochet_scene_position(loop, place)
  if (error /= 0) call exit(error)
  print "(*(es24.16))", n_t, place
  flush (6)
  do while (ricochet_ongoing(loop) == 1 .and. error == 0)
    error = ricochet_write(loop, zero, record=zero)
    if (error == 0) error = ricochet_advance(loop)
  end do
  call exit(ricochet_close(loop))
end program lump
)f90";

/// A block with that lump at its back flies onto a plane.
std::string lumped_scene(const std::string& program) {
  return R"(model = "plane_strain"
[[body]]
name = "tail"
foreign = true
joined_to = "block"
surface = "end"
[[body]]
name = "block"
material = { youngs_modulus_pa = 210e9, poisson_ratio = 0.3, density_kg_m3 = 7800.0 }
mesh = { start_m = -0.08, length_m = 0.04, height_m = 0.02, elements = [2, 4] }
initial_velocity_m_s = [0.0, -5.0]
[contact]
surfaces = ["block.start", "rigid_plane"]
[partition]
implicit_length_m = { block = 0.04 }
[time]
step_s = 5e-7
end_s = 20e-6
[coupling]
timeout_s = 3.0
start_timeout_s = 3.0
[[participant]]
name = "theirs"
role = "explicit"
bodies = ["tail"]
executable = ")" +
         program + R"("
[[participant]]
name = "implicit"
role = "implicit"
)";
}

void c_and_fortran_are_told_directions_and_places(const Package& package) {
  const auto& folder = package.folder;
  const auto include = package.prefix + "/include/ricochet", path = folder.path().string();
  package.run(linked(package, {"cc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror",
                               folder.write(lump_in_c, "lump.c"), "-o", path + "/lump_c", "-I" + include}));
  package.run(linked(package, {"gfortran", "-O2", "-Wall", "-Werror", "-J", path, "-o", path + "/lump_f",
                               include + "/ricochet.f90", folder.write(lump_in_fortran, "lump.f90")}));
  for (const std::string language : {"c", "f"}) {
    const auto run = run_text(lumped_scene(path + "/lump_" + language), folder, language);
    std::istringstream log(file_text(run.folder + "/logs/theirs.log"));
    const std::vector<double> told{std::istream_iterator<double>(log), {}};
    EXPECT_EQ(told, (std::vector<double>{0, -1, 1, 0, 0, -0.04, 0.01, -0.04, 0.02, -0.04})) << language;
    if (language == "f") continue;
    EXPECT_THAT(run.outcome.error,
                testing::AllOf(testing::HasSubstr("set-up: 'theirs' casting, "), testing::HasSubstr(" %")));
  }
}

/// The header is plain C; calls that make no sense are named.
void calls_from_c_that_are_wrong_are_named(const Package& package) {
  const auto source = package.folder.write(R"(#include <ricochet.h>
#include <string.h>

int main(void) {
  double zero[1] = {0};
  int body[1] = {0};
  ricochet_loop* loop = ricochet_open("explicit", "misuse", 1);
  if (!loop) return 2;
  const char* what = ricochet_name(loop);
  if (!strcmp(what, "role")) return ricochet_open("implict", "misuse", 1) ? 0 : 2;
  if (!strcmp(what, "capability")) return ricochet_add_capability(loop, "repeat_windows");
  if (!strcmp(what, "nodes")) return ricochet_set_interface(loop, -1, body, zero, zero);
  if (!strcmp(what, "early")) return ricochet_read(loop, zero);
  if (!strcmp(what, "none")) return ricochet_advance(NULL);
  if (ricochet_initialize(loop, zero, zero) == 0) return 0;
  return ricochet_add_body(loop, "late");
}
)",
                                           "misuse.c");
  const auto program = (package.folder.path() / "misuse").string();
  const std::vector<std::string> command{
      "cc",      "-std=c99", "-Wall", "-Wextra", "-Wpedantic",
      "-Werror", source,     "-o",    program,   "-I" + package.prefix + "/include/ricochet"};
  package.run(linked(package, command));
  const auto says = [&](const std::string& name, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {program, "--name", name, "--connect", "nowhere"});
    const auto outcome = run_command(more, package.folder.path().string());
    EXPECT_EQ(outcome.code, 2) << name;
    return outcome.error;
  };
  using testing::HasSubstr;
  EXPECT_THAT(says("role"),
              HasSubstr("unknown role \"implict\", allowed are explicit, implicit; did you mean \"implicit\"?"));
  EXPECT_THAT(says("capability"), HasSubstr("found \"repeat_windows\", allowed are repeat_window, driven_by_force, "
                                            "reconfigure; did you mean \"repeat_window\"?"));
  EXPECT_THAT(says("nodes"), HasSubstr("nodes: error: ricochet_set_interface: found -1 nodes, allowed are >= 0"));
  EXPECT_THAT(says("early"), HasSubstr("ricochet_read must come after ricochet_initialize"));
  EXPECT_THAT(says("none"), HasSubstr("ricochet_advance was called without a loop: ricochet_open gave none"));
  EXPECT_THAT(says("late"), HasSubstr("cannot connect to 'nowhere'"));
  EXPECT_THAT(says("late"), HasSubstr("ricochet_add_body must come before ricochet_initialize"));
  EXPECT_THAT(says("late", {"--thing"}), HasSubstr("unexpected argument \"--thing\", allowed are"));
}

/// One test: each would have to install and build anew.
TEST(Package, IsFoundBuiltAgainstAndRun) {
  const Package package;
  takes_part_in_a_run(package);
  keeps_the_contract(package);
  headers_include_nothing_that_is_not_installed(package);
  python_participant_runs_from_its_place(package);
  command_line_errors_name_what_is_wrong(package);
  fortran_participant_takes_part_in_runs(package);
  implicit_participant_in_c_takes_part_in_a_run(package);
  c_and_fortran_are_told_directions_and_places(package);
  calls_from_c_that_are_wrong_are_named(package);
}

}  // namespace
}  // namespace ricochet::test
