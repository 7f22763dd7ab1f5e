// bench_factors [--plane N,...] [--solid N,...] [--folder DIR]: the factor of the implicit operator, ours against MUMPS
// (if its sequential library was found when this was built), of the reference scene and of two blocks of hexahedra.
// One line each: unknowns, processor time of the factorisation and of one solve, memory held by the factor and at most
// while it was made. Each is measured in a process of its own, by one thread.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "common/problem/problem.hpp"
#include "implicit_solver/condensed_factor.hpp"
#include "tests/bench/reference_scene.hpp"

#ifdef RICOCHET_MUMPS
#include <dmumps_c.h>
#endif

namespace ricochet::bench {
namespace {

/// A = M + dt^2/4 K of all bodies with the free degrees of freedom, and those of the contact.
struct ImplicitOperator {
  fem::SparseMatrix a;
  std::vector<bool> active;
  std::vector<int> root;
  Eigen::VectorXd b;
};

ImplicitOperator operator_of(const std::string& scene_path) {
  const auto problem = scene::build_problem(scene::load_scene(scene_path));
  const int components = problem.scene.components();
  const double factor = 0.25 * problem.clock.size_s() * problem.clock.size_s();
  const auto& contact = problem.contacts.front();
  std::vector<Eigen::Triplet<double>> entries;
  ImplicitOperator result;
  int offset = 0;
  for (const auto& owned : scene::participant_parts(problem, problem.scene.participants.front())) {
    const auto& part = owned.part;
    for (int row = 0; row < part.dofs(); ++row) {
      result.active.push_back(
          !problem.bodies[static_cast<std::size_t>(owned.body)].fixed_dof[static_cast<std::size_t>(row)]);
      entries.emplace_back(offset + row, offset + row, part.lumped_mass[row / components]);
      for (fem::SparseMatrix::InnerIterator it(part.stiffness, row); it; ++it)
        entries.emplace_back(offset + row, offset + static_cast<int>(it.col()), factor * it.value());
    }
    for (const auto& pair : contact.pairs) {
      const int node = owned.body == contact.body_a ? pair.node_a : pair.b.front().node;
      for (int c = 0; c < components; ++c) {
        const int dof = offset + node * components + c;
        if (result.active[static_cast<std::size_t>(dof)]) result.root.push_back(dof);
      }
    }
    offset += part.dofs();
  }
  result.a.resize(offset, offset);
  result.a.setFromTriplets(entries.begin(), entries.end());
  result.b.setRandom(offset);
  return result;
}

std::string write_blocks(int elements, const std::string& path) {
  constexpr double edge_m = 1e-3;
  const auto block = [&](const char* name, double start_m, double velocity_m_s) {
    return fmt::format(
        "[[body]]\nname = \"{}\"\nmaterial = {{ youngs_modulus_pa = 48e9, poisson_ratio = 0.2, density_kg_m3 = 2800.0 "
        "}}\nmesh = {{ start_m = {}, length_m = {}, height_m = {}, width_m = {}, elements = [{}, {}, {}] }}\n"
        "initial_velocity_m_s = [0.0, 0.0, {:.1f}]\n",
        name, start_m, 2 * elements * edge_m, elements * edge_m, elements * edge_m, elements, elements, 2 * elements,
        velocity_m_s);
  };
  write_atomically(path, "model = \"solid\"\n" + block("lower", -2 * elements * edge_m, 1.0) +
                             block("upper", 0.0, -1.0) +
                             "[contact]\nsurfaces = [\"lower.end\", \"upper.start\"]\n[time]\nstep_s = 1e-7\nend_s = "
                             "2e-6\n[coupling]\nprotocol = \"all_implicit\"\n");
  return path;
}

struct Cost {
  double unknowns = 0.0, factor_s = 0.0, solve_s = 0.0, held_b = 0.0, peak_b = 0.0, wall_solve_s = 0.0;
};

double processor_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double wall_s() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// "VmRSS" or "VmHWM", its largest so far [bytes].
double memory_b(const std::string& what) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(what + ":", 0) == 0) return 1024.0 * std::stod(line.substr(what.size() + 1));
  }
  return 0.0;
}

void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

/// `factorise` and `solve` of one factor.
Cost measure(double unknowns, const std::function<void()>& factorise, const std::function<void()>& solve) {
  constexpr int solves = 5;
  Cost cost;
  cost.unknowns = unknowns;
  forget_peak();
  const double before_b = memory_b("VmRSS"), begin_s = processor_s();
  factorise();
  cost.factor_s = processor_s() - begin_s;
  cost.held_b = memory_b("VmRSS") - before_b;
  solve();
  const double solves_from_s = processor_s(), from_s = wall_s();
  for (int i = 0; i < solves; ++i) solve();
  cost.solve_s = (processor_s() - solves_from_s) / solves;
  cost.wall_solve_s = (wall_s() - from_s) / solves;
  cost.peak_b = memory_b("VmHWM") - before_b;
  return cost;
}

constexpr std::size_t most_contact_dofs_in_root = 800;  // as WindowSolver has it

double unknowns_of(const ImplicitOperator& op) {
  return static_cast<double>(std::count(op.active.begin(), op.active.end(), true));
}

Cost ours(ImplicitOperator& op) {
  if (op.root.size() > most_contact_dofs_in_root) op.root.clear();
  std::unique_ptr<implicit_solver::CondensedFactor> factor;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(op.b.size());
  return measure(
      unknowns_of(op), [&] { factor = std::make_unique<implicit_solver::CondensedFactor>(op.a, op.active, op.root); },
      [&] {
        factor->forward(op.b);
        factor->backward(factor->root_inverse() * factor->root_rhs(), x);
      });
}

#ifdef RICOCHET_MUMPS
/// Symmetric positive definite, its own choice of an order; with `out_of_core` the factor lies in files of `folder`.
Cost mumps(ImplicitOperator& op, bool out_of_core, const std::string& folder) {
  std::vector<int> unknown_of(op.active.size(), 0), rows, columns;
  int unknowns = 0;
  for (std::size_t dof = 0; dof < op.active.size(); ++dof) {
    if (op.active[dof]) unknown_of[dof] = ++unknowns;
  }
  std::vector<double> values;
  for (int r = 0; r < op.a.outerSize(); ++r) {
    for (fem::SparseMatrix::InnerIterator it(op.a, r); it; ++it) {
      const int i = unknown_of[static_cast<std::size_t>(r)], j = unknown_of[static_cast<std::size_t>(it.col())];
      if (i == 0 || j == 0 || j > i) continue;
      rows.push_back(i);
      columns.push_back(j);
      values.push_back(it.value());
    }
  }
  std::vector<double> x(static_cast<std::size_t>(unknowns), 1.0);
  DMUMPS_STRUC_C id{};
  const auto call = [&](int job) {
    id.job = job;
    dmumps_c(&id);
    if (id.infog[0] < 0) throw SolverError(fmt::format("MUMPS: job {}, error {} ({})", job, id.infog[0], id.infog[1]));
  };
  id.comm_fortran = -987654;
  id.par = id.sym = 1;
  call(-1);
  for (const int message : {0, 1, 2, 3}) id.icntl[message] = message < 3 ? -1 : 0;
  id.icntl[21] = out_of_core ? 1 : 0;
  std::snprintf(id.ooc_tmpdir, sizeof id.ooc_tmpdir, "%s", folder.c_str());
  id.n = unknowns;
  id.nnz = static_cast<MUMPS_INT8>(values.size());
  id.irn = rows.data();
  id.jcn = columns.data();
  id.a = values.data();
  id.rhs = x.data();
  const Cost cost = measure(
      unknowns, [&] { call(4); }, [&] { call(3); });
  call(-2);
  return cost;
}
#endif

/// In a child, so that what one frees is not another's.
Cost in_child(const std::function<Cost()>& compute) {
  int ends[2];
  if (pipe(ends) != 0) throw MachineError("no pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    try {
      const Cost cost = compute();
      _exit(write(ends[1], &cost, sizeof cost) == static_cast<ssize_t>(sizeof cost) ? 0 : 1);
    } catch (const std::exception& error) {
      fmt::print(stderr, "bench_factors: {}\n", error.what());
      _exit(1);
    }
  }
  close(ends[1]);
  Cost cost;
  const bool told = child > 0 && read(ends[0], &cost, sizeof cost) == static_cast<ssize_t>(sizeof cost);
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!told || status != 0) throw ParticipantError("a measurement did not finish");
  return cost;
}

void print(const std::string& scene, const char* solver, const Cost& cost) {
  fmt::print("{:<10} {:<20} {:>9.0f} {:>12.2f} {:>13.2f} {:>13.2f} {:>9.0f} {:>9.0f}\n", scene, solver, cost.unknowns,
             cost.factor_s, 1e3 * cost.solve_s, 1e3 * cost.wall_solve_s, 1e-6 * cost.held_b, 1e-6 * cost.peak_b);
  std::fflush(stdout);
}

void compare(const std::string& name, const std::string& scene, const std::string& folder) {
  const auto row = [&](const char* solver, const std::function<Cost(ImplicitOperator&)>& of) {
    print(name, solver, in_child([&] {
            ImplicitOperator op = operator_of(scene);
            return of(op);
          }));
  };
  row("condensed factor", ours);
#ifdef RICOCHET_MUMPS
  row("MUMPS", [&](ImplicitOperator& op) { return mumps(op, false, folder); });
  row("MUMPS, out of core", [&](ImplicitOperator& op) { return mumps(op, true, folder); });
#else
  static_cast<void>(folder);
#endif
}

void run(const std::vector<int>& planes, const std::vector<int>& solids, const std::string& folder) {
  std::filesystem::create_directories(folder);
#ifndef RICOCHET_MUMPS
  fmt::print("built without MUMPS (Debian's libmumps-seq-dev)\n");
#endif
  fmt::print("{:<10} {:<20} {:>9} {:>12} {:>13} {:>13} {:>9} {:>9}\n", "scene", "factor", "unknowns", "factorise [s]",
             "a solve [ms]", "its wall [ms]", "held [MB]", "peak [MB]");
  for (const int refinement : planes) {
    SceneChoice choice;
    choice.refinement = refinement;
    choice.protocol = "all_implicit";
    compare(fmt::format("plane {}", refinement), write_reference_scene(choice, folder + "/plane.toml"), folder);
  }
  for (const int elements : solids)
    compare(fmt::format("solid {}", elements), write_blocks(elements, folder + "/solid.toml"), folder);
}

}  // namespace
}  // namespace ricochet::bench

int main(int argc, char** argv) {
  using namespace ricochet;
  CLI::App app("The factor of the implicit operator against MUMPS.");
  std::vector<int> planes = {1, 2, 4, 8}, solids = {8, 12, 16};
  std::string folder = "out/factors";
  app.add_option("--plane", planes, "Refinements of the reference scene; 0 for none")->delimiter(',');
  app.add_option("--solid", solids, "Elements across each of two blocks; 0 for none")->delimiter(',');
  app.add_option("--folder", folder, "For scenes and the files of factors out of core")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  for (auto* list : {&planes, &solids}) list->erase(std::remove(list->begin(), list->end(), 0), list->end());
  try {
    bench::run(planes, solids, folder);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_factors: {}\n", error.what());
    return 1;
  }
}
