#include "coupler/contract/contract_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/error.hpp"
#include "coupler/contract/contract_response.hpp"
#include "coupler/processes/executable.hpp"
#include "coupler/watch/scene_comparison.hpp"

namespace ricochet::coupler {
namespace {

using Values = std::vector<double>;

/// A share of the largest value of a quantity.
constexpr double tolerance = 1e-3;

Values difference(Values a, const Values& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

const std::string& body_of(const ContractRun& run, std::size_t node) {
  return run.description.bodies[static_cast<std::size_t>(run.description.interface_body.data[node])];
}

Values position_of(const ContractRun& run, std::size_t node) {
  const auto begin = run.description.interface_position_m.data.begin();
  const auto components = run.description.components;
  const auto at = static_cast<std::ptrdiff_t>(node) * components;
  return {begin + at, begin + at + components};
}

/// Per row of `a` that of `b` whose node is the nearest of the same body.
std::vector<std::size_t> rows_beside(const ContractRun& a, const ContractRun& b) {
  const auto components = static_cast<std::size_t>(a.description.components);
  const auto nodes_a = a.size() / components, nodes_b = b.size() / static_cast<std::size_t>(b.description.components);
  if (nodes_a != nodes_b || a.description.components != b.description.components) {
    fail(fmt::format("it has {} interface nodes of {} components, the shipped solver {} of {}", nodes_a, components,
                     nodes_b, b.description.components));
  }
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < nodes_a; ++i) {
    double nearest = INFINITY;
    std::size_t found = nodes_b;
    for (std::size_t j = 0; j < nodes_b; ++j) {
      if (body_of(a, i) != body_of(b, j)) continue;
      const double distance = largest(difference(position_of(a, i), position_of(b, j)));
      if (distance < nearest) {
        nearest = distance;
        found = j;
      }
    }
    if (found == nodes_b) fail(fmt::format("the shipped solver has no interface node of body '{}'", body_of(a, i)));
    for (std::size_t c = 0; c < components; ++c) rows.push_back(found * components + c);
  }
  return rows;
}

/// The values that are furthest from the shipped solver's, in shares of the largest value of its quantity.
struct Furthest {
  double share = 0.0;
  std::string text = "all numbers are equal";

  void look(double found, double expected, double scale, const std::string& where) {
    const double off = scale > 0.0 ? std::abs(found - expected) / scale : 0.0;
    if (!(off > share)) return;
    share = off;
    text = fmt::format("{} is {:.6g}, the shipped solver's {:.6g}, which differs by {:.2g} of the largest", where,
                       found, expected, off);
  }
};

/// Link values of all windows; throws at the first window with one that is too far off.
void compare_link(const ContractRun& ours, const ContractRun& theirs, const std::vector<std::size_t>& row_of,
                  Furthest& furthest) {
  struct Quantity {
    const char* name;
    const Values &theirs, &ours;
  };
  const Quantity quantities[] = {
      {theirs.by_force ? "displacement [m]" : "internal force [N]", theirs.output, ours.output},
      {"velocity [m/s]", theirs.velocity, ours.velocity},
      {"acceleration [m/s^2]", theirs.acceleration, ours.acceleration}};
  const std::size_t size = theirs.size(), components = static_cast<std::size_t>(theirs.description.components);
  for (std::size_t window = 0; size > 0 && window < theirs.output.size() / size; ++window) {
    Furthest here;
    for (const auto& q : quantities) {
      const double scale = largest(q.ours);
      for (std::size_t row = 0; row < size && !q.theirs.empty(); ++row) {
        here.look(q.theirs[window * size + row], q.ours[window * size + row_of[row]], scale,
                  fmt::format("window {}, body '{}', interface node {} at ({:.6g}) m, component {}: {}", window,
                              body_of(theirs, row / components), row / components,
                              fmt::join(position_of(theirs, row / components), ", "), row % components, q.name));
      }
    }
    if (here.share > tolerance) fail(here.text);
    if (here.share > furthest.share) furthest = here;
  }
}

/// How hard a contact problem was to solve is no result.
bool is_effort(const std::string& column) {
  return column == "contact_iterations" || column == "contact_residual" || column == "contact_unconverged";
}

/// The unit that a column's name ends in; of a number without one its name.
std::string unit_of(const std::string& column) {
  const auto name = column.substr(0, column.find('/'));
  for (const char* unit : {"_kg_m2_s", "_kg_m_s", "_n_s", "_kg", "_pa", "_j", "_n", "_m"}) {
    const std::string end = unit;
    if (name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0) return end;
  }
  return name;
}

/// The largest value of all columns in that unit, of lengths also of the interface's displacement: of sums that cancel,
/// and of gaps that are closed, rounding alone is left.
double scale_of(const ContractRun& run, const std::string& column) {
  const auto unit = unit_of(column);
  double scale = unit == "_m" ? largest(run.by_force ? run.output : run.input) : 0.0;
  for (const auto& other : run.description.record_columns) {
    if (unit_of(other) == unit && !is_effort(other)) scale = std::max(scale, largest(run.column(other)));
  }
  return scale;
}

/// History columns that both have.
void compare_history(const ContractRun& ours, const ContractRun& theirs, Furthest& furthest) {
  for (const auto& name : theirs.description.record_columns) {
    const auto& columns = ours.description.record_columns;
    if (is_effort(name) || std::find(columns.begin(), columns.end(), name) == columns.end()) continue;
    const Values a = theirs.column(name), b = ours.column(name);
    const double scale = scale_of(ours, name);
    Furthest here;
    for (std::size_t row = 0; row < std::min(a.size(), b.size()); ++row) {
      here.look(a[row], b[row], scale, fmt::format("window {}: history column {}", row, name));
      if (here.share > tolerance) fail(here.text);
    }
    if (here.share > furthest.share) furthest = here;
  }
}

}  // namespace

ContractScene::ContractScene(const scene::Problem& problem, const std::string& name)
    : problem_(problem), participant_(problem.scene.participant(name)) {}

std::vector<std::string> ContractScene::command(std::vector<std::string> words) const {
  if (words.empty()) words.push_back(find_executable(problem_.scene, participant_));
  for (const auto& word : {std::string("--scene"), problem_.scene.path, std::string("--name"), participant_.name})
    words.push_back(word);
  return words;
}

ContractDrive ContractScene::drive(ContractDrive basis) const {
  basis.by_force = problem_.scene.coupling.protocol.dual && participant_.role == Role::explicit_solver;
  basis.substeps = basis.by_force ? participant_.substeps : 1;
  if (basis.window_size_s <= 0.0) basis.window_size_s = problem_.clock.size_s(1);
  return basis;
}

PeerDescription ContractScene::description_of(const ContractRun& run) const {
  return {run.description, participant_.name, participant_.role};
}

void ContractScene::require_no_difference() const {
  for (const auto& other : problem_.scene.participants) {
    if (other.differing_bodies.empty()) continue;
    throw NotApplicable{
        fmt::format("the scene says that differing_bodies of participant '{}' are other models", other.name)};
  }
}

void ContractScene::require_meshed_bodies() const {
  for (const auto& body : participant_.bodies) {
    if (problem_.scene.is_foreign(body))
      throw NotApplicable{fmt::format("\"{}\" is foreign: the scene has no elements of it", body)};
  }
}

std::string ContractScene::declares_the_scene(const ContractCommand& command) const {
  ContractPeer peer(command);
  ContractRun run;
  describe(peer, command.timeout_s, run);
  const auto description = description_of(run);
  if (!SceneComparison::possible(problem_, description)) {
    fail(fmt::format("it has {} components per node, the scene has {}", description.components,
                     problem_.scene.components()));
  }
  SceneComparison(problem_, description).check_description();
  return "";
}

std::string ContractScene::answers_as_the_elements(const ContractCommand& command) const {
  require_meshed_bodies();
  ContractPeer peer(command);
  ContractRun run;
  describe(peer, command.timeout_s, run);
  if (run.size() == 0) throw NotApplicable{"it has no interface nodes"};
  if (run.implicit()) throw NotApplicable{"it is implicit: what the shipped solver does says more"};
  const auto description = description_of(run);
  if (!SceneComparison::possible(problem_, description)) throw NotApplicable{"its interface is another"};
  const SceneComparison comparison(problem_, description);
  const auto how = drive({});
  start(peer, how, run);
  const auto probe = comparison.probe(run.by_force ? Drive::force : Drive::displacement);
  const Values zero(run.size(), 0.0);
  if (how.by_force) {
    const auto before = try_window(peer, run, 1, zero, zero, false),
               after = try_window(peer, run, 1, zero, probe, false);
    comparison.check_window(probe, difference(after.velocity, before.velocity), how.substeps);
  } else {
    const auto before = synchronise(peer, run, zero, Integration::explicit_central),
               after = synchronise(peer, run, probe, Integration::explicit_central);
    comparison.check_stiffness(probe, difference(after.output, before.output));
  }
  return "";
}

std::string ContractScene::computes_what_the_shipped_solver_does(const ContractCommand& command,
                                                                 const ContractDrive& basis) const {
  require_no_difference();
  require_meshed_bodies();
  auto shipped = participant_;
  shipped.executable.clear();
  shipped.ranks.reset();
  ContractCommand ours = command;
  ours.words = {find_executable(problem_.scene, shipped), "--scene", problem_.scene.path, "--name", participant_.name};
  auto how = drive(basis);
  ContractRun theirs, reference;
  run_contract(command, how, theirs);
  {
    ContractPeer peer(ours);
    ContractRun described;
    describe(peer, ours.timeout_s, described);
    reference.description = described.description;
  }
  const auto row_of = rows_beside(theirs, reference);
  how.inputs.assign(theirs.input.size(), 0.0);
  for (std::size_t k = 0; k < theirs.input.size(); ++k) {
    const std::size_t window = k / theirs.size();
    how.inputs[window * theirs.size() + row_of[k % theirs.size()]] = theirs.input[k];
  }
  reference = {};
  run_contract(ours, how, reference);
  Furthest furthest;
  compare_link(reference, theirs, row_of, furthest);
  compare_history(reference, theirs, furthest);
  return furthest.text;
}

}  // namespace ricochet::coupler
