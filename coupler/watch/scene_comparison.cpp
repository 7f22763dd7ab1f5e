#include "coupler/watch/scene_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "common/problem/critical_step.hpp"
#include "coupler/watch/tried_causes.hpp"

namespace ricochet::coupler {
namespace {

/// A cause is tried to a millionth of the extent: files have few digits.
constexpr double tried_place = 1e3;

/// Largest extent of all shared nodes along a coordinate, or the largest coordinate, as InterfaceMap has it [m].
double interface_extent(const scene::Problem& problem) {
  double result = 0.0;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(HUGE_VAL), high = -low;
  for (int b = 0; b < static_cast<int>(problem.bodies.size()); ++b) {
    const auto shared = scene::shared_nodes(problem, b);
    for (std::size_t i = 0; i < shared.size(); ++i) {
      if (!shared[i]) continue;
      low = low.cwiseMin(problem.bodies[fem::at(b)].mesh.position[i]);
      high = high.cwiseMax(problem.bodies[fem::at(b)].mesh.position[i]);
    }
  }
  for (Eigen::Index c = 0; c < 3; ++c) {
    if (low[c] <= high[c]) result = std::max({result, high[c] - low[c], std::abs(high[c])});
  }
  return result;
}

std::vector<std::string> axes_of(scene::Model model) {
  if (model == scene::Model::bar) return {"x"};
  if (model == scene::Model::axisymmetric) return {"r", "z"};
  if (model == scene::Model::plane_strain) return {"x", "y"};
  return {"x", "y", "z"};
}

}  // namespace

namespace {

/// Everyone who computes the body has another model than the scene's: they agree on its nodes among themselves.
bool is_nobodys(const scene::Scene& scene, const std::string& body) {
  return std::all_of(scene.participants.begin(), scene.participants.end(), [&](const scene::ParticipantSpec& one) {
    const auto has = [&](const std::vector<std::string>& names) {
      return std::find(names.begin(), names.end(), body) != names.end();
    };
    return has(one.differing_bodies) || (one.role == Role::explicit_solver && !has(one.bodies));
  });
}

}  // namespace

bool may_differ(const scene::Scene& scene, const std::string& body) {
  const auto lists = [&](const scene::ParticipantSpec& participant) {
    const auto& listed = participant.differing_bodies;
    return std::find(listed.begin(), listed.end(), body) != listed.end();
  };
  return std::any_of(scene.participants.begin(), scene.participants.end(), lists);
}

bool SceneComparison::possible(const scene::Problem& problem, const PeerDescription& description) {
  const auto &body = description.interface_body, &place = description.interface_position_m,
             &mass = description.interface_mass_kg;
  const auto has_body = [&](double index) {
    return index >= 0.0 && index < static_cast<double>(description.bodies.size()) && index == std::floor(index);
  };
  const auto believable = [](double kg) { return kg >= 0.0 && kg <= InterfaceMap::largest_mass_kg; };
  return description.components == problem.scene.components() &&
         place.data.size() == body.data.size() * fem::at(problem.scene.components()) &&
         mass.data.size() == body.data.size() && std::all_of(body.data.begin(), body.data.end(), has_body) &&
         std::all_of(mass.data.begin(), mass.data.end(), believable);
}

SceneComparison::SceneComparison(const scene::Problem& problem, const PeerDescription& description)
    : problem_(problem),
      description_(description),
      parts_(scene::participant_parts(problem, problem.scene.participant(description.participant))),
      axes_(axes_of(problem.scene.model)),
      components_(axes_.size()),
      place_tolerance_m_(InterfaceMap::same_place * interface_extent(problem)) {
  for (std::size_t row = 0; row < description_.interface_body.data.size(); ++row) {
    const auto near = nearest(body_of(row), place_of(row));
    nodes_.push_back(near.distance_m <= place_tolerance_m_ ? near.node : Node{});
  }
  const bool summed = description_.role == Role::implicit_solver && !problem.scene.coupling.protocol.dual;
  for (const auto& part : parts_) {
    const bool touches = description_.role == Role::implicit_solver;
    contact_nodes_.push_back(touches ? scene::contact_nodes(problem.contacts, part.body) : std::vector<int>());
    auto& mass = integrated_mass_kg_.emplace_back(part.part.lumped_mass);
    if (!summed) continue;
    const Eigen::VectorXd whole = scene::body_lumped_mass(problem.bodies[fem::at(part.body)]);
    for (Eigen::Index i = 0; i < mass.size(); ++i) mass[i] = whole[part.part.body_node[static_cast<std::size_t>(i)]];
  }
}

const std::string& SceneComparison::body_of(std::size_t row) const {
  return description_.bodies[static_cast<std::size_t>(description_.interface_body.data[row])];
}

Eigen::Vector3d SceneComparison::place_of(std::size_t row) const {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < components_; ++c)
    x[static_cast<Eigen::Index>(c)] = description_.interface_position_m.data[row * components_ + c];
  return x;
}

SceneComparison::Near SceneComparison::nearest(const std::string& body, const Eigen::Vector3d& x) const {
  Near near;
  const auto look = [&](const Eigen::Vector3d& place, const Node& node) {
    const double distance_m = (place - x).norm();
    if (distance_m < near.distance_m) near = {node, place, distance_m};
  };
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    if (parts_[p].part.body != body) continue;
    for (const int local : parts_[p].shared)
      look(parts_[p].part.mesh.position[fem::at(local)], {static_cast<int>(p), local});
  }
  for (const auto& joint : problem_.joints) {
    if (joint.foreign != body) continue;
    for (const int node : joint.nodes) look(problem_.bodies[fem::at(joint.body)].mesh.position[fem::at(node)], {});
  }
  return near;
}

std::vector<double> SceneComparison::scene_places() const {
  std::vector<double> places;
  for (std::size_t row = 0; row < nodes_.size(); ++row) {
    const auto near = nearest(body_of(row), place_of(row));
    places.insert(places.end(), near.place_m.data(), near.place_m.data() + components_);
  }
  return places;
}

bool SceneComparison::left_out(std::size_t row) const {
  return nodes_[row].part < 0 || may_differ(problem_.scene, body_of(row));
}

bool SceneComparison::held(std::size_t row, int component) const {
  const auto& part = parts_[fem::at(nodes_[row].part)];
  const int node = part.part.body_node[fem::at(nodes_[row].local)];
  const auto& touching = contact_nodes_[fem::at(nodes_[row].part)];
  const auto& body = problem_.bodies[fem::at(part.body)];
  if (std::binary_search(touching.begin(), touching.end(), node)) return true;
  if (description_.role == Role::implicit_solver && body.joined_node[fem::at(node)]) return true;
  return body.fixed_dof[fem::at(node) * components_ + fem::at(component)];
}

std::string SceneComparison::place_text(const Eigen::Vector3d& x) const {
  return fmt::format("({:.9g}) m", fmt::join(x.data(), x.data() + components_, ", "));
}

std::string SceneComparison::where(std::size_t row) const {
  return fmt::format("participant '{}', body '{}', interface node {} at {}", description_.participant, body_of(row),
                     row, place_text(place_of(row)));
}

std::string SceneComparison::advice(int body) const {
  return fmt::format(
      "; if the body is meant to be another than the scene's, add differing_bodies = [\"{}\"] to its "
      "[[participant]]",
      problem_.bodies[fem::at(body)].name);
}

void SceneComparison::check_description() const {
  for (std::size_t row = 0; row < nodes_.size(); ++row) check_place(row);
  check_all_are_there();
  check_masses();
}

void SceneComparison::check_place(std::size_t row) const {
  const auto& name = body_of(row);
  const auto& own = problem_.scene.participant(description_.participant).bodies;
  const bool foreign = problem_.scene.is_foreign(name);
  if (foreign && std::find(own.begin(), own.end(), name) == own.end())
    throw ConfigError(
        fmt::format("{}: found a foreign body of another participant; allowed: {}", where(row), fmt::join(own, ", ")));
  const auto is = [&](const scene::BodyProblem& body) { return body.name == name; };
  if (!foreign && std::none_of(problem_.bodies.begin(), problem_.bodies.end(), is))
    throw ConfigError(fmt::format("{}: the scene has no such body", where(row)));
  if (is_nobodys(problem_.scene, name)) return;
  const auto near = nearest(name, place_of(row));
  if (near.distance_m <= place_tolerance_m_) return;
  if (near.distance_m == HUGE_VAL)
    throw ConfigError(fmt::format("{}: the scene has no node of that body that this participant shares", where(row)));
  const auto what = foreign ? fmt::format("\"{}\" is joined to no node there", name)
                            : std::string("the scene's mesh has no interface node there");
  std::vector<Eigen::Vector3d> places;
  for (std::size_t i = 0; i < nodes_.size(); ++i) places.push_back(place_of(i));
  const auto cause = places_cause(places, axes_, [this](std::size_t i, const Eigen::Vector3d& x) {
    return nearest(body_of(i), x).distance_m <= tried_place * place_tolerance_m_;
  });
  throw ConfigError(fmt::format("{}: {}; the nearest is at {}, {:.3g} m away, allowed are {:.3g} m{}", where(row), what,
                                place_text(near.place_m), near.distance_m, place_tolerance_m_, as_cause(cause)));
}

/// Each node that the scene shares with it, or is joined to it at, is one of its own.
void SceneComparison::check_all_are_there() const {
  const auto check = [this](const std::string& body, const std::vector<Eigen::Vector3d>& places, const auto& why,
                            const std::string& allowed) {
    std::vector<Eigen::Vector3d> missing;
    const auto rows = rows_of(body);
    for (const auto& place : places) {
      const auto is_there = [&](std::size_t row) { return (place_of(row) - place).norm() <= place_tolerance_m_; };
      if (std::none_of(rows.begin(), rows.end(), is_there)) missing.push_back(place);
    }
    if (missing.empty()) return;
    throw ConfigError(fmt::format(
        "participant '{}', body '{}': it has no interface node at {}, {} ({} of {} are missing); allowed: {}",
        description_.participant, body, place_text(missing.front()), why, missing.size(), places.size(), allowed));
  };
  for (const auto& part : parts_) {
    if (is_nobodys(problem_.scene, part.part.body)) continue;
    std::vector<Eigen::Vector3d> places;
    for (const int local : part.shared) places.push_back(part.part.mesh.position[fem::at(local)]);
    check(part.part.body, places, "where the scene's mesh has a shared one", "all of them");
  }
  const auto& own = problem_.scene.participant(description_.participant).bodies;
  for (const auto& joint : problem_.joints) {
    if (std::find(own.begin(), own.end(), joint.foreign) == own.end()) continue;
    const auto& body = problem_.bodies[fem::at(joint.body)];
    std::vector<Eigen::Vector3d> places;
    for (const int node : joint.nodes) places.push_back(body.mesh.position[fem::at(node)]);
    check(joint.foreign, places, fmt::format("where \"{}\" is joined to \"{}\"", joint.foreign, body.name),
          fmt::format("all of them, or interface_nodes of [[body]] \"{}\", a file with those that it has",
                      joint.foreign));
  }
}

std::vector<std::size_t> SceneComparison::rows_of(const std::string& body) const {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < nodes_.size(); ++row) {
    if (body_of(row) == body) rows.push_back(row);
  }
  return rows;
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
  if (error <= comparison_tolerance) return;
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

}  // namespace ricochet::coupler
