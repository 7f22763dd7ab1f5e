// Answers of the scene's own elements in a participant's place, what it answered, and its first row of history.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "coupler/watch/scene_comparison.hpp"
#include "coupler/watch/tried_causes.hpp"

namespace ricochet::coupler {
namespace {

/// Displacement that is tried, in extents of the interface's bodies; and the velocity that a force is sized for [m/s].
constexpr double probe_share = 1e-6, probe_velocity_m_s = 1.0;

/// Half the diagonal of what the nodes fill [m].
double extent(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position.front(), high = low;
  for (const auto& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return 0.5 * (high - low).norm();
}

/// Those numbers alone.
std::vector<double> picked(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  std::vector<double> result;
  for (const auto row : rows) result.push_back(values[row]);
  return result;
}

}  // namespace

std::vector<double> SceneComparison::probe(Drive drive) const {
  std::vector<double> result;
  for (std::size_t row = 0; row < nodes_.size(); ++row) {
    for (std::size_t c = 0; c < components_; ++c) {
      const double wave = std::sin(1.0 + 12.9898 * static_cast<double>(result.size()));
      const double shape = wave + std::copysign(0.5, wave);
      if (left_out(row) || held(row, static_cast<int>(c))) {
        result.push_back(0.0);
      } else if (drive == Drive::displacement) {
        result.push_back(probe_share * extent(problem_.bodies[fem::at(parts_[fem::at(nodes_[row].part)].body)].mesh) *
                         shape);
      } else {
        const double step_s = problem_.clock.size_s(1) / problem_.scene.participant(description_.participant).substeps;
        result.push_back(description_.interface_mass_kg.data[row] * probe_velocity_m_s / step_s * shape);
      }
    }
  }
  return result;
}

SceneComparison::Response SceneComparison::internal_force(const std::vector<double>& probe) const {
  std::vector<Eigen::VectorXd> u, force;
  for (const auto& part : parts_) u.emplace_back(Eigen::VectorXd::Zero(part.part.dofs()));
  const auto count = static_cast<int>(components_);
  for (std::size_t i = 0; i < probe.size(); ++i) {
    const Node& node = nodes_[i / components_];
    if (node.part >= 0) u[fem::at(node.part)][node.local * count + static_cast<int>(i % components_)] = probe[i];
  }
  for (std::size_t p = 0; p < parts_.size(); ++p) force.emplace_back(parts_[p].part.stiffness * u[p]);
  Response response(probe.size(), 0.0);
  for (std::size_t i = 0; i < probe.size(); ++i) {
    const Node& node = nodes_[i / components_];
    if (node.part >= 0) response[i] = force[fem::at(node.part)][node.local * count + static_cast<int>(i % components_)];
  }
  return response;
}

/// M a = lambda - K u by central differences from rest, with the part's own masses.
SceneComparison::Response SceneComparison::velocity(const std::vector<double>& probe, int substeps) const {
  const auto count = static_cast<int>(components_);
  const double dt = problem_.clock.size_s(1) / substeps;
  Response response(probe.size(), 0.0);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto& part = parts_[p].part;
    const auto& body = problem_.bodies[fem::at(parts_[p].body)];
    Eigen::VectorXd load = Eigen::VectorXd::Zero(part.dofs()), inverse = load, u = load, v = load, a = load;
    for (int dof = 0; dof < part.dofs(); ++dof) {
      const bool fixed =
          body.fixed_dof[fem::at(part.body_node[fem::at(dof / count)]) * components_ + fem::at(dof % count)];
      if (!fixed) inverse[dof] = 1.0 / part.lumped_mass[dof / count];
    }
    const auto dof_of = [&](std::size_t i) {
      return nodes_[i / components_].local * count + static_cast<int>(i % components_);
    };
    for (std::size_t i = 0; i < probe.size(); ++i) {
      if (nodes_[i / components_].part == static_cast<int>(p)) load[dof_of(i)] = probe[i];
    }
    for (int step = 1; step <= substeps; ++step) {
      u += dt * v + 0.5 * dt * dt * a;
      v += 0.5 * dt * a;
      a = inverse.cwiseProduct(load * (static_cast<double>(step) / substeps) - part.stiffness * u);
      v += 0.5 * dt * a;
    }
    for (std::size_t i = 0; i < probe.size(); ++i) {
      if (nodes_[i / components_].part == static_cast<int>(p)) response[i] = v[dof_of(i)];
    }
  }
  return response;
}

SceneComparison::Response SceneComparison::acceleration(const std::vector<double>& probe) const {
  Response response;
  for (std::size_t i = 0; i < probe.size(); ++i) {
    const Node& node = nodes_[i / components_];
    response.push_back(node.part < 0 ? 0.0 : -probe[i] / integrated_mass_kg_[fem::at(node.part)][node.local]);
  }
  return response;
}

/// Another arrangement of rows in what it takes, answers, or both, that gives what was found.
template <class Respond>
std::string SceneComparison::arrangement_cause(const std::vector<double>& found, const std::vector<std::size_t>& rows,
                                               const std::vector<double>& probe, const Respond& respond) const {
  const auto answer = respond(probe);
  for (const auto& other : other_arrangements(description_.interface_body.data, axes_)) {
    const auto is = [&](const std::vector<double>& tried) { return agree(found, picked(tried, rows)); };
    const auto taken = respond(other.applied(probe));
    if (is(other.applied(answer))) return fmt::format("{} in what it answers", other.name);
    if (is(taken)) return fmt::format("{} in what it takes", other.name);
    if (is(other.undone(taken)))
      return fmt::format("{} in what it takes and answers, not in its positions", other.name);
  }
  return "";
}

template <class Respond>
void SceneComparison::compare(const std::string& quantity, const char* unit, const std::vector<double>& probe,
                              const std::vector<double>& change, const Respond& respond) const {
  std::vector<std::size_t> rows;  // that were tried
  for (std::size_t i = 0; i < probe.size(); ++i) {
    if (probe[i] != 0.0) rows.push_back(i);
  }
  if (rows.empty()) return;
  const auto found = picked(change, rows), expected = picked(respond(probe), rows);
  if (agree(found, expected)) return;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (std::abs(found[i] - expected[i]) > std::abs(found[worst] - expected[worst])) worst = i;
  }
  std::string cause;
  if (const auto factor = common_factor(found, expected)) {
    cause = known_slip(*factor);
    if (cause.empty()) cause = fmt::format("it is {:.6g} times what it should be, at every node", *factor);
  }
  if (cause.empty()) cause = arrangement_cause(found, rows, probe, respond);
  const std::size_t row = rows[worst] / components_;
  throw ConfigError(fmt::format("{}, component {}: {} is {:.6g} {}, the scene's own elements give {:.6g} {}{}{}",
                                where(row), rows[worst] % components_, quantity, found[worst], unit, expected[worst],
                                unit, as_cause(cause), advice(parts_[fem::at(nodes_[row].part)].body)));
}

void SceneComparison::check_stiffness(const std::vector<double>& probe, const std::vector<double>& change) const {
  compare(fmt::format("its internal force P = K u to displacements of some {:.2g} m at the interface", largest(probe)),
          "N", probe, change, [this](const std::vector<double>& input) { return internal_force(input); });
}

void SceneComparison::check_window(const std::vector<double>& probe, const std::vector<double>& change,
                                   int substeps) const {
  // With dashpots at the interface the scene's own answer would need more than K and M.
  for (const auto& part : parts_) {
    if (problem_.bodies[fem::at(part.body)].damping_kg_s.squaredNorm() > 0.0) return;
  }
  compare(fmt::format("its velocity after a window of {} step{} by forces of some {:.2g} N at the interface", substeps,
                      substeps == 1 ? "" : "s", largest(probe)),
          "m/s", probe, change, [&](const std::vector<double>& input) { return velocity(input, substeps); });
}

void SceneComparison::check_acceleration(const std::vector<double>& probe, const std::vector<double>& change) const {
  compare(fmt::format("its acceleration by forces of some {:.2g} N at the interface", largest(probe)), "m/s^2", probe,
          change, [this](const std::vector<double>& input) { return acceleration(input); });
}

void SceneComparison::try_link(Link& link, int substeps) const {
  if (parts_.empty() || nodes_.empty()) return;
  const auto drive = link.driven_by_force() ? Drive::force : Drive::displacement;
  const auto integration = link.implicit() ? Integration::implicit_newmark : Integration::explicit_central;
  const auto tried = probe(drive), input = link.input();
  std::vector<double> other = input;
  for (std::size_t i = 0; i < other.size(); ++i) other[i] += tried[i];
  const auto difference = [](std::vector<double> a, const std::vector<double>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
    return a;
  };
  const auto synchronise = [&](const std::vector<double>& values) {
    link.post_synchronise(integration, values);
    link.wait_synchronised();
  };
  const auto velocity_after = [&](const std::vector<double>& values) {
    link.post_advance({}, values, Acceptance::trial);
    link.wait_advanced();
    return link.velocity_m_s();
  };
  if (drive == Drive::force && !link.implicit()) {
    const auto before = velocity_after(input), after = velocity_after(other);
    synchronise(input);
    check_window(tried, difference(after, before), substeps);
    return;
  }
  const auto answer = [&] { return link.implicit() ? link.acceleration_m_s2() : link.output(); };
  const auto before = answer();
  synchronise(other);
  const auto after = answer();
  synchronise(input);
  if (link.implicit()) {
    check_acceleration(tried, difference(after, before));
  } else {
    check_stiffness(tried, difference(after, before));
  }
}

/// In a baseline, and driven by force, it integrates every node of its elements.
bool SceneComparison::integrates(std::size_t part, int local, Drive drive) const {
  if (description_.role == Role::implicit_solver || drive == Drive::force) return true;
  const auto& shared = parts_[part].shared;
  return !std::binary_search(shared.begin(), shared.end(), local);
}

void SceneComparison::check_body(std::size_t part, const std::string& quantity, double found, double expected,
                                 double scale, const char* unit) const {
  if (std::abs(found - expected) <= comparison_tolerance * scale) return;
  std::string cause;
  if (std::abs(expected) > comparison_tolerance * scale) {
    cause = known_slip(found / expected);
    if (cause.empty()) cause = fmt::format("it is {:.6g} times what it should be", found / expected);
  }
  const int body = parts_[part].body;
  throw ConfigError(fmt::format(
      "participant '{}', body '{}': its first row of history has {}/{} = {:.6g} {}, the scene's mesh, density and "
      "initial velocity give {:.6g} {} of the nodes that it integrates{}{}",
      description_.participant, problem_.bodies[fem::at(body)].name, quantity, problem_.bodies[fem::at(body)].name,
      found, unit, expected, unit, as_cause(cause), advice(body)));
}

void SceneComparison::check_first_row(const std::vector<double>& row, Drive drive) const {
  const Eigen::Vector3d normal = scene::momentum_normal(problem_);
  const auto count = static_cast<int>(components_);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const int index = parts_[p].body;
    const auto& body = problem_.bodies[fem::at(index)];
    const bool joined = std::any_of(problem_.joints.begin(), problem_.joints.end(),
                                    [&](const scene::Joint& joint) { return joint.body == index; });
    if (may_differ(problem_.scene, body.name) || (joined && description_.role == Role::implicit_solver)) continue;
    const auto& part = parts_[p].part;
    double mass = 0.0, momentum = 0.0, size = 0.0;
    for (int local = 0; local < part.nodes(); ++local) {
      if (!integrates(p, local, drive)) continue;
      const int node = part.body_node[fem::at(local)];
      const double m = integrated_mass_kg_[p][local];
      mass += m;
      for (int c = 0; c < count; ++c) {
        const double v = body.initial_velocity_m_s[node * count + c];
        momentum += m * v * normal[c];
        size += m * std::abs(v);
      }
    }
    const bool driven = !problem_.scene.body(body.name).prescribed.empty();
    for (std::size_t c = 0; c < description_.record_columns.size() && c < row.size(); ++c) {
      const auto& column = description_.record_columns[c];
      if (column == "mass_kg/" + body.name) check_body(p, "mass_kg", row[c], mass, mass, "kg");
      if (column == "momentum_n_kg_m_s/" + body.name && size > 0.0 && !driven)
        check_body(p, "momentum_n_kg_m_s", row[c], momentum, size, "kg m/s");
    }
  }
  for (const auto& body : problem_.scene.foreign_bodies) check_whole_mass(body, row, drive);
}

/// Driven by displacement its row is of the nodes that it integrates: what it has at the others it has declared.
void SceneComparison::check_whole_mass(const scene::ForeignBody& body, const std::vector<double>& row,
                                       Drive drive) const {
  const auto& columns = description_.record_columns;
  const auto column =
      static_cast<std::size_t>(std::find(columns.begin(), columns.end(), "mass_kg/" + body.name) - columns.begin());
  if (!body.mass_kg || column >= std::min(columns.size(), row.size())) return;
  double mass_kg = row[column];
  for (const auto i : drive == Drive::displacement ? rows_of(body.name) : std::vector<std::size_t>{})
    mass_kg += description_.interface_mass_kg.data[i];
  if (std::abs(mass_kg - *body.mass_kg) <= comparison_tolerance * *body.mass_kg) return;
  throw ConfigError(fmt::format(
      "participant '{}', body '{}': its mass is {:.6g} kg (mass_kg/{} of its first row of history{}), {} is {:.6g} kg "
      "({:.4g} times){}",
      description_.participant, body.name, mass_kg, body.name,
      drive == Drive::displacement ? " and 'interface_mass_kg'" : "",
      problem_.scene.where("body." + body.name + ".mass_kg"), *body.mass_kg, mass_kg / *body.mass_kg,
      as_cause(known_slip(mass_kg / *body.mass_kg))));
}

}  // namespace ricochet::coupler
