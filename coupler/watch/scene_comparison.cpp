#include "coupler/watch/scene_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/error.hpp"
#include "common/problem/critical_step.hpp"
#include "coupler/interface/vectors.hpp"

namespace ricochet::coupler {
namespace {

constexpr double tolerance = 1e-3;
/// Of a body's extent: nodes this close are one.
constexpr double same_place = 1e-6;
/// Displacement that is tried, in extents of the interface's bodies; and the velocity that a force is sized for [m/s].
constexpr double probe_share = 1e-6, probe_velocity_m_s = 1.0;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

/// Half the diagonal of what the nodes fill [m].
double extent(const fem::Mesh& mesh) {
  Eigen::Vector3d low = mesh.position.front(), high = low;
  for (const auto& x : mesh.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  return 0.5 * (high - low).norm();
}

/// The factor between two vectors, if it is one for all rows.
std::optional<double> common_factor(const std::vector<double>& found, const std::vector<double>& expected) {
  const double factor = view(found).dot(view(expected)) / view(expected).squaredNorm();
  const double rest = (view(found) - factor * view(expected)).cwiseAbs().maxCoeff();
  if (!std::isfinite(factor) || rest > tolerance * std::abs(factor) * largest(expected)) return std::nullopt;
  return factor;
}

bool agree(const std::vector<double>& found, const std::vector<double>& expected) {
  return (view(found) - view(expected)).cwiseAbs().maxCoeff() <= tolerance * largest(expected);
}

/// Row i of the result is row order[i].
std::vector<double> permuted(const std::vector<double>& values, const std::vector<std::size_t>& order) {
  std::vector<double> result;
  for (const auto i : order) result.push_back(values[i]);
  return result;
}

struct Order {
  const char* name;
  std::vector<std::size_t> rows;
};

/// Orders in which somebody may have meant rows of nodes of these bodies.
std::vector<Order> other_orders(const std::vector<double>& bodies, std::size_t components) {
  const std::size_t nodes = bodies.size();
  std::vector<Order> orders{{"the order of the nodes is reversed", {}},
                            {"the order of the nodes of each body is reversed", {}},
                            {"rows go by node, as if they went by component", {}},
                            {"rows go by component, not by node", {}}};
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto same = [&](double body) { return body == bodies[i]; };
    const auto first = std::find_if(bodies.begin(), bodies.end(), same) - bodies.begin(),
               last = bodies.rend() - std::find_if(bodies.rbegin(), bodies.rend(), same) - 1;
    for (std::size_t c = 0; c < components; ++c) {
      orders[0].rows.push_back((nodes - 1 - i) * components + c);
      orders[1].rows.push_back((static_cast<std::size_t>(first + last) - i) * components + c);
      orders[2].rows.push_back(c * nodes + i);
    }
  }
  orders[3].rows.resize(orders[2].rows.size());
  for (std::size_t i = 0; i < orders[2].rows.size(); ++i) orders[3].rows[orders[2].rows[i]] = i;
  if (components == 1) orders.resize(2);
  return orders;
}

std::string as_cause(const std::string& text) { return text.empty() ? "" : "; likely cause: " + text; }

}  // namespace

std::string known_slip(double ratio) {
  const auto is = [ratio](double value) { return std::abs(ratio / value - 1.0) <= tolerance; };
  if (is(-1.0)) return "its sign is wrong (P resists a positive displacement; L acts with a minus)";
  if (is(0.5 * M_1_PI)) return "it is per radian, it must be that of the full circle";
  if (is(2.0 * M_PI)) return "it is that of 2 pi full circles: 2 pi was multiplied twice";
  if (is(2.0)) return "a factor 2: the nodes' whole mass or force was taken twice, or that of both sides";
  if (is(0.5)) return "a factor 1/2: half an element is missing at the interface";
  for (const double unit : {1e3, 1e6, 1e9, 1e12}) {
    if (is(unit) || is(1.0 / unit))
      return fmt::format("a factor {:g}: everything is in SI units (m, kg, s, N)", ratio > 1.0 ? unit : 1.0 / unit);
  }
  return "";
}

bool SceneComparison::possible(const scene::Problem& problem, const PeerDescription& description) {
  const auto &body = description.interface_body, &place = description.interface_position_m,
             &mass = description.interface_mass_kg;
  const auto has_body = [&](double index) {
    return index >= 0.0 && index < static_cast<double>(description.bodies.size()) && index == std::floor(index);
  };
  const auto believable = [](double kg) { return kg >= 0.0 && kg <= InterfaceMap::largest_mass_kg; };
  return description.components == problem.scene.components() &&
         place.data.size() == body.data.size() * at(problem.scene.components()) &&
         mass.data.size() == body.data.size() && std::all_of(body.data.begin(), body.data.end(), has_body) &&
         std::all_of(mass.data.begin(), mass.data.end(), believable);
}

SceneComparison::SceneComparison(const scene::Problem& problem, const PeerDescription& description)
    : problem_(problem),
      description_(description),
      parts_(scene::participant_parts(problem, problem.scene.participant(description.participant))),
      components_(at(problem.scene.components())) {
  for (std::size_t row = 0; row < description_.interface_body.data.size(); ++row) nodes_.push_back(find(row));
  const bool summed = description_.role == Role::implicit_solver && !problem.scene.coupling.protocol.dual;
  for (const auto& part : parts_) {
    const bool touches = description_.role == Role::implicit_solver;
    contact_nodes_.push_back(touches ? scene::contact_nodes(problem.contacts, part.body) : std::vector<int>());
    auto& mass = integrated_mass_kg_.emplace_back(part.part.lumped_mass);
    if (!summed) continue;
    const Eigen::VectorXd whole = scene::body_lumped_mass(problem.bodies[at(part.body)]);
    for (Eigen::Index i = 0; i < mass.size(); ++i) mass[i] = whole[part.part.body_node[static_cast<std::size_t>(i)]];
  }
}

Eigen::Vector3d SceneComparison::place_of(std::size_t row) const {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < components_; ++c)
    x[static_cast<Eigen::Index>(c)] = description_.interface_position_m.data[row * components_ + c];
  return x;
}

SceneComparison::Node SceneComparison::find(std::size_t row) const {
  const auto& body = description_.bodies[static_cast<std::size_t>(description_.interface_body.data[row])];
  const Eigen::Vector3d x = place_of(row);
  double nearest = INFINITY;
  Node found;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto& part = parts_[p];
    if (part.part.body != body) continue;
    for (const int local : part.shared) {
      const double distance = (part.part.mesh.position[at(local)] - x).norm();
      if (distance >= nearest) continue;
      nearest = distance;
      found = {static_cast<int>(p), local};
    }
  }
  const bool here =
      found.part >= 0 && nearest <= same_place * extent(problem_.bodies[at(parts_[at(found.part)].body)].mesh);
  return here ? found : Node{};
}

bool SceneComparison::differs(int body) const {
  const auto& name = problem_.bodies[at(body)].name;
  const auto& participants = problem_.scene.participants;
  return std::any_of(participants.begin(), participants.end(), [&](const scene::ParticipantSpec& participant) {
    const auto& listed = participant.differing_bodies;
    return std::find(listed.begin(), listed.end(), name) != listed.end();
  });
}

bool SceneComparison::left_out(std::size_t row) const {
  return nodes_[row].part < 0 || differs(parts_[at(nodes_[row].part)].body);
}

bool SceneComparison::held(std::size_t row, int component) const {
  const auto& part = parts_[at(nodes_[row].part)];
  const int node = part.part.body_node[at(nodes_[row].local)];
  const auto& touching = contact_nodes_[at(nodes_[row].part)];
  const auto& body = problem_.bodies[at(part.body)];
  if (std::binary_search(touching.begin(), touching.end(), node)) return true;
  if (description_.role == Role::implicit_solver && body.joined_node[at(node)]) return true;
  return body.fixed_dof[at(node) * components_ + at(component)];
}

std::string SceneComparison::where(std::size_t row) const {
  const auto begin = description_.interface_position_m.data.begin() + static_cast<std::ptrdiff_t>(row * components_);
  const std::vector<double> x(begin, begin + static_cast<std::ptrdiff_t>(components_));
  return fmt::format("participant '{}', body '{}', interface node {} at ({:.6g}) m", description_.participant,
                     description_.bodies[static_cast<std::size_t>(description_.interface_body.data[row])], row,
                     fmt::join(x, ", "));
}

std::string SceneComparison::advice(int body) const {
  return fmt::format(
      "; if the body is meant to be another than the scene's, add differing_bodies = [\"{}\"] to its "
      "[[participant]]",
      problem_.bodies[at(body)].name);
}

void SceneComparison::check_description() const {
  for (std::size_t row = 0; row < nodes_.size(); ++row) {
    if (nodes_[row].part >= 0) continue;
    const auto& name = description_.bodies[static_cast<std::size_t>(description_.interface_body.data[row])];
    const auto& own = problem_.scene.participant(description_.participant).bodies;
    if (problem_.scene.is_foreign(name)) {
      if (std::find(own.begin(), own.end(), name) != own.end()) continue;
      throw ConfigError(fmt::format("{}: found a foreign body of another participant; allowed: {}", where(row),
                                    fmt::join(own, ", ")));
    }
    const auto is = [&](const scene::BodyProblem& body) { return body.name == name; };
    const auto body = std::find_if(problem_.bodies.begin(), problem_.bodies.end(), is);
    if (body == problem_.bodies.end()) throw ConfigError(fmt::format("{}: the scene has no such body", where(row)));
    const int index = static_cast<int>(body - problem_.bodies.begin());
    if (differs(index)) continue;
    throw ConfigError(fmt::format("{}: the scene's mesh has no interface node there{}", where(row), advice(index)));
  }
  const auto& own = problem_.scene.participant(description_.participant).bodies;
  for (const auto& joint : problem_.joints) {
    if (std::find(own.begin(), own.end(), joint.foreign) != own.end()) check_joint(joint);
  }
  check_masses();
}

std::vector<std::size_t> SceneComparison::rows_of(const std::string& body) const {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < nodes_.size(); ++row) {
    if (description_.bodies[static_cast<std::size_t>(description_.interface_body.data[row])] == body)
      rows.push_back(row);
  }
  return rows;
}

void SceneComparison::check_joint(const scene::Joint& joint) const {
  const auto& body = problem_.bodies[at(joint.body)];
  const double near_m = same_place * extent(body.mesh);
  std::vector<bool> found(joint.nodes.size(), false);
  for (const auto row : rows_of(joint.foreign)) {
    const auto distance = [&, x = place_of(row)](int node) { return (body.mesh.position[at(node)] - x).norm(); };
    const auto nearest = std::min_element(joint.nodes.begin(), joint.nodes.end(),
                                          [&](int a, int b) { return distance(a) < distance(b); });
    if (distance(*nearest) > near_m)
      throw ConfigError(fmt::format(
          "{}: \"{}\" is joined to \"{}\" at no node there; allowed: the joined nodes, the nearest of which is at {}",
          where(row), joint.foreign, body.name,
          fem::place_text(problem_.scene.model, body.mesh.position[at(*nearest)])));
    found[static_cast<std::size_t>(nearest - joint.nodes.begin())] = true;
  }
  const auto missing = std::find(found.begin(), found.end(), false) - found.begin();
  if (missing == std::ssize(found)) return;
  throw ConfigError(fmt::format(
      "participant '{}', body '{}': it has no interface node at {}, where \"{}\" is joined to \"{}\" ({} of {} joined "
      "nodes are missing); allowed: all of them, or interface_nodes of [[body]] \"{}\", a file with those that it has",
      description_.participant, joint.foreign,
      fem::place_text(problem_.scene.model, body.mesh.position[at(joint.nodes[static_cast<std::size_t>(missing)])]),
      joint.foreign, body.name, std::count(found.begin(), found.end(), false), found.size(), joint.foreign));
}

void SceneComparison::check_masses() const {
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    std::vector<std::size_t> rows;
    for (std::size_t row = 0; row < nodes_.size(); ++row) {
      if (nodes_[row].part == static_cast<int>(part) && !left_out(row)) rows.push_back(row);
    }
    check_masses_of(part, rows);
  }
}

void SceneComparison::check_masses_of(std::size_t part, const std::vector<std::size_t>& rows) const {
  std::vector<double> found, expected;
  std::size_t worst = 0;
  double error = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    found.push_back(description_.interface_mass_kg.data[rows[i]]);
    expected.push_back(parts_[part].part.lumped_mass[nodes_[rows[i]].local]);
    const double off = std::abs(found[i] - expected[i]) / expected[i];
    if (off <= error) continue;
    error = off;
    worst = i;
  }
  if (error <= tolerance) return;
  std::string cause;
  const auto factor = common_factor(found, expected);
  if (factor) cause = known_slip(*factor);
  if (factor && cause.empty() && rows.size() > 1)
    cause = fmt::format("all {} nodes have {:.6g} times their mass", rows.size(), *factor);
  if (!factor && agree(found, {expected.rbegin(), expected.rend()})) cause = "the order of the nodes is reversed";
  throw ConfigError(fmt::format(
      "{}: its 'interface_mass_kg' is {:.6g} kg, the scene's mesh and density give {:.6g} kg ({:.4g} times){}{}",
      where(rows[worst]), found[worst], expected[worst], found[worst] / expected[worst], as_cause(cause),
      advice(parts_[part].body)));
}

std::vector<double> SceneComparison::probe(Drive drive) const {
  std::vector<double> result;
  for (std::size_t row = 0; row < nodes_.size(); ++row) {
    for (std::size_t c = 0; c < components_; ++c) {
      const double wave = std::sin(1.0 + 12.9898 * static_cast<double>(result.size()));
      const double shape = wave + std::copysign(0.5, wave);
      if (left_out(row) || held(row, static_cast<int>(c))) {
        result.push_back(0.0);
      } else if (drive == Drive::displacement) {
        result.push_back(probe_share * extent(problem_.bodies[at(parts_[at(nodes_[row].part)].body)].mesh) * shape);
      } else {
        const double step_s = problem_.window_size_s / problem_.scene.coupling.substeps;
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
    if (node.part >= 0) u[at(node.part)][node.local * count + static_cast<int>(i % components_)] = probe[i];
  }
  for (std::size_t p = 0; p < parts_.size(); ++p) force.emplace_back(parts_[p].part.stiffness * u[p]);
  Response response(probe.size(), 0.0);
  for (std::size_t i = 0; i < probe.size(); ++i) {
    const Node& node = nodes_[i / components_];
    if (node.part >= 0) response[i] = force[at(node.part)][node.local * count + static_cast<int>(i % components_)];
  }
  return response;
}

/// M a = lambda - K u by central differences from rest, with the part's own masses.
SceneComparison::Response SceneComparison::velocity(const std::vector<double>& probe, int substeps) const {
  const auto count = static_cast<int>(components_);
  const double dt = problem_.window_size_s / substeps;
  Response response(probe.size(), 0.0);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto& part = parts_[p].part;
    const auto& body = problem_.bodies[at(parts_[p].body)];
    Eigen::VectorXd load = Eigen::VectorXd::Zero(part.dofs()), inverse = load, u = load, v = load, a = load;
    for (int dof = 0; dof < part.dofs(); ++dof) {
      const bool fixed = body.fixed_dof[at(part.body_node[at(dof / count)]) * components_ + at(dof % count)];
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
    response.push_back(node.part < 0 ? 0.0 : -probe[i] / integrated_mass_kg_[at(node.part)][node.local]);
  }
  return response;
}

template <class Respond>
void SceneComparison::compare(const std::string& quantity, const char* unit, const std::vector<double>& probe,
                              const std::vector<double>& change, const Respond& respond) const {
  if (std::all_of(probe.begin(), probe.end(), [](double x) { return x == 0.0; })) return;
  const auto scene_answer = respond(probe);
  std::vector<std::size_t> rows;  // that were tried
  for (std::size_t i = 0; i < probe.size(); ++i) {
    if (probe[i] != 0.0) rows.push_back(i);
  }
  const auto found = permuted(change, rows), expected = permuted(scene_answer, rows);
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
  for (const auto& order : other_orders(description_.interface_body.data, components_)) {
    if (!cause.empty()) break;
    const auto taken = respond(permuted(probe, order.rows));
    std::vector<double> both(probe.size());
    for (std::size_t i = 0; i < probe.size(); ++i) both[order.rows[i]] = taken[i];
    const auto is = [&](const std::vector<double>& answer) { return agree(found, permuted(answer, rows)); };
    if (is(permuted(scene_answer, order.rows))) cause = fmt::format("{} in what it answers", order.name);
    if (is(taken)) cause = fmt::format("{} in what it takes", order.name);
    if (is(both)) cause = fmt::format("{} in what it takes and answers, not in its positions", order.name);
  }
  const std::size_t row = rows[worst] / components_;
  throw ConfigError(fmt::format("{}, component {}: {} is {:.6g} {}, the scene's own elements give {:.6g} {}{}{}",
                                where(row), rows[worst] % components_, quantity, found[worst], unit, expected[worst],
                                unit, as_cause(cause), advice(parts_[at(nodes_[row].part)].body)));
}

void SceneComparison::check_stiffness(const std::vector<double>& probe, const std::vector<double>& change) const {
  compare(fmt::format("its internal force P = K u to displacements of some {:.2g} m at the interface", largest(probe)),
          "N", probe, change, [this](const std::vector<double>& input) { return internal_force(input); });
}

void SceneComparison::check_window(const std::vector<double>& probe, const std::vector<double>& change,
                                   int substeps) const {
  // Of dashpots at the interface the scene's own answer would need more than K and M.
  for (const auto& part : parts_) {
    if (problem_.bodies[at(part.body)].damping_kg_s.squaredNorm() > 0.0) return;
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
  if (std::abs(found - expected) <= tolerance * scale) return;
  std::string cause;
  if (std::abs(expected) > tolerance * scale) {
    cause = known_slip(found / expected);
    if (cause.empty()) cause = fmt::format("it is {:.6g} times what it should be", found / expected);
  }
  const int body = parts_[part].body;
  throw ConfigError(fmt::format(
      "participant '{}', body '{}': its first row of history has {}/{} = {:.6g} {}, the scene's mesh, density and "
      "initial velocity give {:.6g} {} of the nodes that it integrates{}{}",
      description_.participant, problem_.bodies[at(body)].name, quantity, problem_.bodies[at(body)].name, found, unit,
      expected, unit, as_cause(cause), advice(body)));
}

void SceneComparison::check_first_row(const std::vector<double>& row, Drive drive) const {
  const Eigen::Vector3d normal = scene::momentum_normal(problem_);
  const auto count = static_cast<int>(components_);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const int index = parts_[p].body;
    const auto& body = problem_.bodies[at(index)];
    const bool joined = std::any_of(problem_.joints.begin(), problem_.joints.end(),
                                    [&](const scene::Joint& joint) { return joint.body == index; });
    if (differs(index) || (joined && description_.role == Role::implicit_solver)) continue;
    const auto& part = parts_[p].part;
    double mass = 0.0, momentum = 0.0, size = 0.0;
    for (int local = 0; local < part.nodes(); ++local) {
      if (!integrates(p, local, drive)) continue;
      const int node = part.body_node[at(local)];
      const double m = integrated_mass_kg_[p][local];
      mass += m;
      for (int c = 0; c < count; ++c) {
        const double v = body.initial_velocity_m_s[node * count + c];
        momentum += m * v * normal[c];
        size += m * std::abs(v);
      }
    }
    const bool driven =
        std::any_of(body.prescribed_index.begin(), body.prescribed_index.end(), [](int i) { return i >= 0; });
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
  if (std::abs(mass_kg - *body.mass_kg) <= tolerance * *body.mass_kg) return;
  throw ConfigError(fmt::format(
      "participant '{}', body '{}': its mass is {:.6g} kg (mass_kg/{} of its first row of history{}), {} is {:.6g} kg "
      "({:.4g} times){}",
      description_.participant, body.name, mass_kg, body.name,
      drive == Drive::displacement ? " and 'interface_mass_kg'" : "",
      problem_.scene.where("body." + body.name + ".mass_kg"), *body.mass_kg, mass_kg / *body.mass_kg,
      as_cause(known_slip(mass_kg / *body.mass_kg))));
}

}  // namespace ricochet::coupler
