// bench_kernels: inner loops of both solvers on both bodies of the reference scene, against plain ways to do the same,
// and what this machine can do at most. The argument of a kernel is the refinement of the 0.5 mm mesh, that of the
// triad the bytes it touches. Counters: bytes and flops per iteration as the roofline counts them.
#include <benchmark/benchmark.h>
#include <sched.h>
#include <unistd.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <thread>
#include <type_traits>

#include "common/base/parallel.hpp"
#include "common/fem/stiffness_product.hpp"
#include "common/problem/problem.hpp"
#include "implicit_solver/condensed_factor.hpp"
#include "tests/bench/reference_scene.hpp"

#pragma GCC diagnostic ignored "-Wpsabi"  // vectors pass between functions of this file only

namespace ricochet::bench {
namespace {

using fem::SparseMatrix;
using ElementStiffness = Eigen::Matrix<double, 8, 8>;

/// One body with K in three forms.
struct Body {
  fem::Part part;
  std::vector<ElementStiffness> element_stiffness;
  fem::StiffnessProduct product;
  Eigen::VectorXd u, force;
};

/// A = M + dt^2/4 K of both bodies, without supports.
struct ImplicitOperator {
  SparseMatrix a;
  std::vector<int> root;  ///< unknowns of the contact nodes
  Eigen::VectorXd b;
};

scene::Problem reference_problem(int refinement) {
  SceneChoice choice;
  choice.refinement = refinement;
  choice.protocol = "all_implicit";
  const auto path = std::filesystem::temp_directory_path() / ("ricochet_kernels_" + std::to_string(getpid()) + ".toml");
  auto problem = scene::build_problem(scene::load_scene(write_reference_scene(choice, path.string())));
  std::filesystem::remove(path);
  return problem;
}

Body body_of(fem::Part part) {
  Body body;
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e) {
    body.element_stiffness.emplace_back(
        fem::element_stiffness(part.section, part.material, fem::element_geometry(part.mesh, e)));
  }
  body.product = fem::StiffnessProduct(part.stiffness, 2);
  body.u.setRandom(part.dofs());
  body.force.setZero(part.dofs());
  body.part = std::move(part);
  return body;
}

std::vector<Body> make_bodies(int refinement) {
  const auto problem = reference_problem(refinement);
  std::vector<Body> bodies;
  for (auto& owned : scene::participant_parts(problem, problem.scene.participants.front()))
    bodies.push_back(body_of(std::move(owned.part)));
  return bodies;
}

/// The bodies of the reference scene.
std::vector<Body>& reference(int refinement) {
  static std::map<int, std::vector<Body>> made;
  if (!made.count(refinement)) made[refinement] = make_bodies(refinement);
  return made[refinement];
}

/// A rectangle of triangles, whose nodes lie beside a grid and whose diagonals run either way, each triangle split into
/// three quadrilaterals, as meshers do it: no two elements are alike. Nodes of the triangles come first.
fem::Mesh split_triangles(double width_m, double length_m, int across, int along) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> beside(-0.15, 0.15);
  fem::Mesh mesh;
  mesh.model = fem::Model::axisymmetric;
  for (int j = 0; j <= along; ++j) {
    for (int i = 0; i <= across; ++i) {
      const double x = i == 0 || i == across ? i : i + beside(random),
                   y = j == 0 || j == along ? j : j + beside(random);
      mesh.position.emplace_back(x * width_m / across, y * length_m / along, 0.0);
    }
  }
  std::map<std::array<int, 2>, int> middles;
  const auto middle_of = [&](int a, int b) {
    const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, mesh.position.size());
    if (is_new) mesh.position.emplace_back(0.5 * (mesh.position[fem::at(a)] + mesh.position[fem::at(b)]));
    return at->second;
  };
  const auto split = [&](const std::array<int, 3>& corner) {
    const auto [a, b, c] = corner;
    const std::array<int, 3> middle{middle_of(a, b), middle_of(b, c), middle_of(c, a)};
    const auto centre = static_cast<int>(mesh.position.size());
    mesh.position.emplace_back((mesh.position[fem::at(a)] + mesh.position[fem::at(b)] + mesh.position[fem::at(c)]) /
                               3.0);
    mesh.elements.push_back({fem::ElementKind::quadrilateral, {a, middle[0], centre, middle[2]}});
    mesh.elements.push_back({fem::ElementKind::quadrilateral, {b, middle[1], centre, middle[0]}});
    mesh.elements.push_back({fem::ElementKind::quadrilateral, {c, middle[2], centre, middle[1]}});
  };
  for (int j = 0; j < along; ++j) {
    for (int i = 0; i < across; ++i) {
      const int a = j * (across + 1) + i, b = a + 1, c = b + across + 1, d = a + across + 1;
      const bool rising = random() % 2 == 0;
      split(rising ? std::array{a, b, c} : std::array{a, b, d});
      split(rising ? std::array{a, c, d} : std::array{b, c, d});
    }
  }
  return mesh;
}

/// One body about as large as both of the reference scene, with as many quadrilaterals, but for a twentieth.
std::vector<Body>& unstructured(int refinement) {
  static std::map<int, std::vector<Body>> made;
  if (made.count(refinement)) return made[refinement];
  const auto mesh = split_triangles(0.005, 0.16, 4 * refinement, 128 * refinement);
  std::vector<int> elements(mesh.elements.size());
  std::iota(elements.begin(), elements.end(), 0);
  made[refinement].push_back(
      body_of(fem::extract_part(mesh, "split", {fem::Model::axisymmetric, 1.0}, {210e9, 0.3, 7850.0}, elements)));
  return made[refinement];
}

/// Dof of the bodies one after the other -> unknown; -1 on supports.
std::vector<int> number_unknowns(const scene::Problem& problem) {
  std::vector<int> unknown_of;
  int next = 0;
  for (const auto& body : problem.bodies) {
    for (const bool fixed : body.fixed_dof) unknown_of.push_back(fixed ? -1 : next++);
  }
  return unknown_of;
}

ImplicitOperator make_operator(int refinement) {
  const auto problem = reference_problem(refinement);
  const auto unknown_of = number_unknowns(problem);
  const double factor = 0.25 * problem.clock.size_s() * problem.clock.size_s();
  std::vector<Eigen::Triplet<double>> entries;
  ImplicitOperator result;
  std::size_t offset = 0;
  for (const auto& owned : scene::participant_parts(problem, problem.scene.participants.front())) {
    const auto& part = owned.part;
    for (int row = 0; row < part.dofs(); ++row) {
      const int i = unknown_of[offset + static_cast<std::size_t>(row)];
      if (i < 0) continue;
      entries.emplace_back(i, i, part.lumped_mass[row / 2]);
      for (SparseMatrix::InnerIterator it(part.stiffness, row); it; ++it) {
        const int j = unknown_of[offset + static_cast<std::size_t>(it.col())];
        if (j >= 0) entries.emplace_back(i, j, factor * it.value());
      }
    }
    for (const auto& pair : problem.contacts.front().pairs) {
      const auto node =
          static_cast<std::size_t>(owned.body == problem.contacts.front().body_a ? pair.node_a : pair.b.front().node);
      for (const std::size_t dof : {2 * node, 2 * node + 1}) {
        if (unknown_of[offset + dof] >= 0) result.root.push_back(unknown_of[offset + dof]);
      }
    }
    offset += static_cast<std::size_t>(part.dofs());
  }
  const auto unknowns = 1 + *std::max_element(unknown_of.begin(), unknown_of.end());
  result.a.resize(unknowns, unknowns);
  result.a.setFromTriplets(entries.begin(), entries.end());
  result.b.setRandom(unknowns);
  return result;
}

const ImplicitOperator& operator_of(int refinement) {
  static std::map<int, ImplicitOperator> made;
  if (!made.count(refinement)) made[refinement] = make_operator(refinement);
  return made[refinement];
}

/// Made once: a kernel is entered anew for every repetition.
template <class Solver>
Solver& factor_of(int refinement) {
  static std::map<int, std::unique_ptr<Solver>> made;
  auto& solver = made[refinement];
  const auto& op = operator_of(refinement);
  if (solver) return *solver;
  if constexpr (std::is_constructible_v<Solver, SparseMatrix, std::vector<bool>, std::vector<int>>) {
    const std::vector<bool> active(static_cast<std::size_t>(op.a.rows()), true);
    solver = std::make_unique<Solver>(op.a, active, op.root);
  } else {
    solver = std::make_unique<Solver>(Eigen::SparseMatrix<double>(op.a));
  }
  return *solver;
}

template <std::vector<Body>& (*bodies_of)(int)>
void stiffness_product(benchmark::State& state) {
  auto& bodies = bodies_of(static_cast<int>(state.range(0)));
  double nonzeros = 0.0, dofs = 0.0;
  for (const auto& body : bodies) {
    nonzeros += static_cast<double>(body.part.stiffness.nonZeros());
    dofs += body.part.dofs();
  }
  for (auto _ : state) {
    for (auto& body : bodies) body.product.multiply(body.u, body.force);
    benchmark::ClobberMemory();
  }
  state.counters["bytes"] = 8.0 * nonzeros + 16.0 * dofs;  // K once, u and K u once, no indices
  state.counters["flops"] = 2.0 * nonzeros;
}

/// Two threads, each on a processor of its own: where other processes compute, too, the system would put both on one.
/// Null if this process may use one only.
std::shared_ptr<Parallel> two_threads() {
  static const auto made = []() -> std::shared_ptr<Parallel> {
    cpu_set_t usable;
    if (sched_getaffinity(0, sizeof usable, &usable) != 0 || CPU_COUNT(&usable) < 2) return nullptr;
    std::vector<int> processors;
    for (int p = 0; p < CPU_SETSIZE; ++p) {
      if (CPU_ISSET(p, &usable)) processors.push_back(p);
    }
    auto parallel = std::make_shared<Parallel>(2);
    std::atomic<int> here{0};
    parallel->for_each(2, [&](int, int thread) noexcept {
      cpu_set_t own;
      CPU_ZERO(&own);
      CPU_SET(processors[static_cast<std::size_t>(thread)], &own);
      sched_setaffinity(0, sizeof own, &own);
      for (++here; here < 2;) std::this_thread::yield();  // so that nobody takes both parts
    });
    return parallel;
  }();
  return made;
}

/// The bodies' K u by two threads.
template <class Bodies>
void multiply_by_two(benchmark::State& state, Bodies& bodies) {
  if (!two_threads()) {
    state.SkipWithError("needs two processors");
    return;
  }
  for (auto& body : bodies) body.product.compute_with(two_threads());
  for (auto _ : state) {
    for (auto& body : bodies) body.product.multiply(body.u, body.force);
    benchmark::ClobberMemory();
  }
  for (auto& body : bodies) body.product.compute_with(nullptr);
}

void stiffness_product_by_two(benchmark::State& state) {
  multiply_by_two(state, reference(static_cast<int>(state.range(0))));
}

template <std::vector<Body>& (*bodies_of)(int)>
void sparse_product(benchmark::State& state) {
  auto& bodies = bodies_of(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    for (auto& body : bodies) body.force.noalias() = body.part.stiffness * body.u;
    benchmark::ClobberMemory();
  }
}

/// The reference of the explicit kernel: stored 8x8 matrices, gather, multiply, scatter.
template <std::vector<Body>& (*bodies_of)(int)>
void element_by_element(benchmark::State& state) {
  auto& bodies = bodies_of(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    for (auto& body : bodies) {
      body.force.setZero();
      for (std::size_t e = 0; e < body.element_stiffness.size(); ++e) {
        const auto& nodes = body.part.mesh.elements[e];
        Eigen::Matrix<double, 8, 1> u;
        for (int i = 0; i < 4; ++i) u.segment<2>(2 * i) = body.u.segment<2>(2 * nodes[static_cast<std::size_t>(i)]);
        const Eigen::Matrix<double, 8, 1> force = body.element_stiffness[e] * u;
        for (int i = 0; i < 4; ++i) {
          body.force.segment<2>(2 * nodes[static_cast<std::size_t>(i)]) += force.segment<2>(2 * i);
        }
      }
    }
    benchmark::ClobberMemory();
  }
}

/// A block of hexahedra, each a copy of the first.
struct SolidBody {
  fem::Part part;
  std::vector<Eigen::Matrix<double, 24, 24>> element_stiffness;
  fem::StiffnessProduct product;
  Eigen::VectorXd u, force;
};

SolidBody make_solid(int refinement) {
  const int across = 4 * refinement, along = 24 * refinement;
  const auto side = fem::graded_coordinates(0.0, 0.01, across, 1.0);
  const auto mesh = fem::block_mesh(side, side, fem::graded_coordinates(0.0, 0.06, along, 1.0));
  std::vector<int> elements(mesh.elements.size());
  std::iota(elements.begin(), elements.end(), 0);
  SolidBody body;
  body.part = fem::extract_part(mesh, "block", {fem::Model::solid, 1.0}, {210e9, 0.3, 7850.0}, elements);
  for (int e = 0; e < static_cast<int>(elements.size()); ++e) {
    body.element_stiffness.emplace_back(
        fem::element_stiffness(body.part.section, body.part.material, fem::element_geometry(body.part.mesh, e)));
  }
  body.product = fem::StiffnessProduct(body.part.stiffness, 3);
  body.u.setRandom(body.part.dofs());
  body.force.setZero(body.part.dofs());
  return body;
}

SolidBody& solid_of(int refinement) {
  static std::map<int, SolidBody> made;
  if (!made.count(refinement)) made[refinement] = make_solid(refinement);
  return made[refinement];
}

void solid_product(benchmark::State& state) {
  auto& body = solid_of(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    body.product.multiply(body.u, body.force);
    benchmark::ClobberMemory();
  }
  state.counters["flops"] = 2.0 * static_cast<double>(body.part.stiffness.nonZeros());
}

void solid_product_by_two(benchmark::State& state) {
  struct {
    SolidBody* body;
    SolidBody* begin() { return body; }
    SolidBody* end() { return body + 1; }
  } one{&solid_of(static_cast<int>(state.range(0)))};
  multiply_by_two(state, one);
}

void solid_sparse_product(benchmark::State& state) {
  auto& body = solid_of(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    body.force.noalias() = body.part.stiffness * body.u;
    benchmark::ClobberMemory();
  }
}

/// The reference of the solid kernel: stored 24x24 matrices, gather, multiply, scatter.
void solid_element_by_element(benchmark::State& state) {
  auto& body = solid_of(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    body.force.setZero();
    for (std::size_t e = 0; e < body.element_stiffness.size(); ++e) {
      const auto& nodes = body.part.mesh.elements[e];
      Eigen::Matrix<double, 24, 1> u;
      for (int i = 0; i < 8; ++i) u.segment<3>(3 * i) = body.u.segment<3>(3 * nodes[static_cast<std::size_t>(i)]);
      const Eigen::Matrix<double, 24, 1> force = body.element_stiffness[e] * u;
      for (int i = 0; i < 8; ++i)
        body.force.segment<3>(3 * nodes[static_cast<std::size_t>(i)]) += force.segment<3>(3 * i);
    }
    benchmark::ClobberMemory();
  }
}

void solve_by(benchmark::State& state, implicit_solver::CondensedFactor& factor, const ImplicitOperator& op) {
  Eigen::VectorXd x = op.b;
  for (auto _ : state) {
    factor.forward(op.b);
    factor.backward(factor.root_inverse() * factor.root_rhs(), x);
    benchmark::ClobberMemory();
  }
  const auto entries = static_cast<double>(factor.factor_entries());
  state.counters["bytes"] = 2.0 * 8.0 * entries + 32.0 * static_cast<double>(op.b.size());  // L twice, no indices
  state.counters["flops"] = 4.0 * entries;
}

void condensed_solve(benchmark::State& state) {
  const auto refinement = static_cast<int>(state.range(0));
  solve_by(state, factor_of<implicit_solver::CondensedFactor>(refinement), operator_of(refinement));
}

void condensed_solve_by_two(benchmark::State& state) {
  if (!two_threads()) {
    state.SkipWithError("needs two processors");
    return;
  }
  static std::map<int, std::unique_ptr<implicit_solver::CondensedFactor>> made;
  auto& factor = made[static_cast<int>(state.range(0))];
  const auto& op = operator_of(static_cast<int>(state.range(0)));
  if (!factor) {
    const std::vector<bool> active(static_cast<std::size_t>(op.a.rows()), true);
    factor = std::make_unique<implicit_solver::CondensedFactor>(op.a, active, op.root, two_threads());
  }
  solve_by(state, *factor, op);
}

template <class Solver>
void cholmod_solve(benchmark::State& state) {
  const auto refinement = static_cast<int>(state.range(0));
  auto& factor = factor_of<Solver>(refinement);
  const auto& op = operator_of(refinement);
  Eigen::VectorXd x = op.b;
  for (auto _ : state) {
    x = factor.solve(op.b);
    benchmark::ClobberMemory();
  }
}

void triad(benchmark::State& state) {
  const auto n = static_cast<Eigen::Index>(state.range(0)) / 24;
  Eigen::VectorXd a = Eigen::VectorXd::Zero(n), b = Eigen::VectorXd::Random(n), c = Eigen::VectorXd::Random(n);
  for (auto _ : state) {
    a.noalias() = b + 3.0 * c;
    benchmark::ClobberMemory();
  }
  state.counters["bytes"] = 24.0 * static_cast<double>(n);
}

/// Independent chains of multiply-adds that never leave the registers.
void multiply_add(benchmark::State& state) {
  using Vector = double __attribute__((vector_size(64)));
  constexpr int chains = 12, rounds = 1000, lanes = 8;
  std::array<Vector, chains> sum{};
  Vector factor = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, term = factor;
  benchmark::DoNotOptimize(factor);
  benchmark::DoNotOptimize(term);
  for (auto _ : state) {
    for (int r = 0; r < rounds; ++r) {
#pragma GCC unroll 12
      for (std::size_t i = 0; i < chains; ++i) sum[i] = sum[i] * factor + term;
    }
    benchmark::DoNotOptimize(sum);
  }
  state.counters["flops"] = 2.0 * chains * rounds * lanes;
}

void meshes(benchmark::internal::Benchmark* kernel) {
  for (const int refinement : {1, 2, 4}) kernel->Arg(refinement);
}

BENCHMARK_TEMPLATE(stiffness_product, reference)->Name("stiffness_product")->Apply(meshes);
BENCHMARK_TEMPLATE(stiffness_product, unstructured)->Name("unstructured_product")->Apply(meshes);
BENCHMARK(stiffness_product_by_two)->Apply(meshes)->UseRealTime();
BENCHMARK_TEMPLATE(sparse_product, reference)->Name("sparse_product")->Apply(meshes);
BENCHMARK_TEMPLATE(sparse_product, unstructured)->Name("unstructured_sparse_product")->Apply(meshes);
BENCHMARK_TEMPLATE(element_by_element, reference)->Name("element_by_element")->Apply(meshes);
BENCHMARK_TEMPLATE(element_by_element, unstructured)->Name("unstructured_element_by_element")->Apply(meshes);
BENCHMARK(solid_product)->Apply(meshes);
BENCHMARK(solid_product_by_two)->Apply(meshes)->UseRealTime();
BENCHMARK(solid_sparse_product)->Apply(meshes);
BENCHMARK(solid_element_by_element)->Apply(meshes);
BENCHMARK(condensed_solve)->Apply(meshes);
BENCHMARK(condensed_solve_by_two)->Apply(meshes)->UseRealTime();
BENCHMARK_TEMPLATE(cholmod_solve, Eigen::CholmodSimplicialLDLT<Eigen::SparseMatrix<double>>)
    ->Name("cholmod_simplicial")
    ->Apply(meshes);
BENCHMARK_TEMPLATE(cholmod_solve, Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>>)
    ->Name("cholmod_supernodal")
    ->Apply(meshes);
BENCHMARK(triad)->RangeMultiplier(4)->Range(1 << 18, 1 << 28);
BENCHMARK(multiply_add);

}  // namespace
}  // namespace ricochet::bench

BENCHMARK_MAIN();
