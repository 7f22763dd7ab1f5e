#include "common/solver/shape_recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string_view>
#include <utility>

#include "common/base/base64.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::solver {
namespace {

/// The numbers of a part that turns: its rotation, and how far its centre has moved.
constexpr int numbers_of_frame = 12;

template <class Number>
std::string packed(const std::vector<Number>& values) {
  return fmt::format("\"{}\"", base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)}));
}

/// Displacements that are drawn larger than they are would push the bodies into each other, or let one that turns grow.
bool uneven(const scene::ContactGeometry& contact) {
  const auto by_gap = [](const scene::ContactPair& x, const scene::ContactPair& y) { return x.gap0_m < y.gap0_m; };
  const auto [low, high] = std::minmax_element(contact.pairs.begin(), contact.pairs.end(), by_gap);
  return contact.sliding || high->gap0_m > low->gap0_m;
}
bool turns(const scene::Body& body) { return body.large_rotation; }

/// An element of a part that yields has what its plastic strain takes off the stress, the equivalent one, and by how
/// much it is hotter than at the start.
Eigen::Index numbers_of_plastic(const BodyState& state) {
  return state.plastic ? state.plastic->components + (state.plastic->heats() ? 2 : 1) : 0;
}

double temperature_rise_k(const BodyState& state, int element) {
  const auto& plasticity = fem::material_of(state.part, element).plasticity;
  return plasticity && plasticity->heat ? state.plastic->temperature_of(element) - plasticity->heat->reference_k : 0.0;
}

}  // namespace

ShapeRecorder::ShapeRecorder(const scene::Problem& problem, const std::vector<BodyState>& states,
                             const participant::Setup& setup, std::string participant, PressedSurface pressing)
    : states_(states),
      pressing_(pressing),
      participant_(std::move(participant)),
      model_(problem.scene.model),
      clock_(&setup.clock),
      nose_(std::any_of(problem.scene.contacts.begin(), problem.scene.contacts.end(),
                        [](const scene::Contact& contact) { return contact.nose_radius_m > 0.0; })),
      uneven_(std::any_of(problem.contacts.begin(), problem.contacts.end(), uneven) ||
              std::any_of(problem.scene.bodies.begin(), problem.scene.bodies.end(), turns)) {
  if (setup.output_directory.empty()) return;
  for (const auto& contact : problem.contacts) {
    const auto name = [&](int body) { return body < 0 ? "" : problem.bodies[fem::at(body)].name; };
    touching_bodies_.push_back(fmt::format("[\"{}\", \"{}\"]", name(contact.body_a), name(contact.body_b)));
  }
  path_ = setup.output_directory + "/" + participant_ + ".shapes.json";
  for (auto* series : {&run_, &touching_}) series->windows.reserve(series->most + 1);
  std::vector<fem::SeenCells> seen;
  std::size_t count = 0;
  for (const auto& state : states) {
    seen.push_back(fem::seen_cells(state.part.mesh));
    count += seen.back().cells.size();
  }
  if (count > fem::SeenCells::most) {
    too_many_cells_ = count;
    return;
  }
  for (std::size_t p = 0; p < states.size(); ++p) {
    parts_.push_back(
        drawn_part(states[p], problem.bodies[static_cast<std::size_t>(states[p].body)], std::move(seen[p])));
    if (pressing.parts) parts_.back().pressed_node = nodes_in_whole((*pressing.parts)[p].part, states[p].part);
  }
}

ShapeRecorder::~ShapeRecorder() { write(); }

ShapeRecorder::Drawn ShapeRecorder::drawn_part(const BodyState& state, const scene::BodyProblem& body,
                                               fem::SeenCells&& seen) const {
  const auto& mesh = state.part.mesh;
  const int components = fem::components(model_);
  Drawn drawn;
  drawn.name = state.name;
  drawn.strip_m = model_ == fem::Model::bar ? std::sqrt(state.part.section.measure) : 0.0;
  for (Eigen::Index dof = 0; dof < body.initial_velocity_m_s.size(); ++dof)
    drawn.velocity_m_s[dof % components] += body.initial_velocity_m_s[dof];
  drawn.velocity_m_s /= static_cast<double>(body.mesh.position.size());
  std::vector<bool> hanging(mesh.position.size(), false);
  for (const auto& node : mesh.hanging) hanging[fem::at(node.node)] = true;
  for (std::size_t i = 0; i < seen.node.size(); ++i) {
    drawn.hangs.push_back(hanging[fem::at(seen.node[i])]);
    const int body_node = state.part.body_node[fem::at(seen.node[i])];
    drawn.body_node.push_back(seen.image[i] ? -1 - body_node : body_node);
    for (int c = 0; c < components; ++c) drawn.position_m.push_back(static_cast<float>(seen.position_m[i][c]));
  }
  std::vector<bool> keep(mesh.position.size(), false);
  for (const int element : seen.element) {
    for (const int node : mesh.elements[fem::at(element)]) keep[fem::at(node)] = true;
  }
  drawn.node = std::move(seen.node);
  drawn.cells = std::move(seen.cells);
  drawn.element = std::move(seen.element);
  for (int dof = 0; dof < state.part.dofs(); ++dof) {
    if (keep[fem::at(dof / components)]) drawn.kept_dof.push_back(dof);
  }
  const auto of_plastic = drawn.element.size() * static_cast<std::size_t>(numbers_of_plastic(state));
  const std::size_t of_contact = pressing_.forces ? drawn.cells.size() : 0,
                    of_frame = state.frame ? numbers_of_frame : 0;
  for (auto& kept : drawn.kept)
    kept.resize(static_cast<Eigen::Index>(drawn.kept_dof.size() + of_plastic + of_contact + of_frame));
  for (auto* per_dof : {&drawn.load_n, &drawn.area_m2}) per_dof->resize(pressing_.forces ? state.part.dofs() : 0);
  return drawn;
}

void ShapeRecorder::note(std::int64_t window) {
  if (path_.empty()) return;
  note(run_, window, window);
  if (touches_) note(touching_, touched_ - 1, window);
}

void ShapeRecorder::note(Series& series, std::int64_t count, std::int64_t window) {
  auto& windows = series.windows;
  if (count % series.every != 0) return;
  if (!windows.empty() && windows.back() == window) {
    windows.pop_back();  // the start may be synchronised more than once
  } else if (windows.size() == series.most) {
    series.every *= 2;
    for (std::size_t i = 0; 2 * i < series.most; ++i) {
      windows[i] = windows[2 * i];
      for (auto& part : parts_) part.kept[series.first + i].swap(part.kept[series.first + 2 * i]);
    }
    windows.resize(series.most / 2);
    if (count % series.every != 0) return;
  }
  keep(series, window);
}

void ShapeRecorder::archive(Archive& a) {
  a(touched_);
  for (auto* series : {&run_, &touching_}) {
    a.any_size(series->windows);
    a(series->every);
    if (series->windows.size() > series->most || series->every < 1) a.refuse("more shapes than are kept");
    for (auto& part : parts_) {
      for (std::size_t w = 0; w < series->windows.size(); ++w) a(part.kept[series->first + w]);
    }
  }
}

/// In the order of the windows, each once.
std::vector<ShapeRecorder::Kept> ShapeRecorder::kept() const {
  std::vector<Kept> all;
  for (const auto* series : {&run_, &touching_}) {
    for (std::size_t w = 0; w < series->windows.size(); ++w) all.push_back({series->windows[w], series->first + w});
  }
  std::stable_sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.window < b.window; });
  const auto same = [](const Kept& a, const Kept& b) { return a.window == b.window; };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  return all;
}

/// Forces of the pairs and their areas by the rows of their gaps: on both surfaces, whichever carries the rows.
void ShapeRecorder::press() {
  for (auto& part : parts_) {
    part.load_n.setZero();
    part.area_m2.setZero();
  }
  const int components = fem::components(model_);
  const auto& pairs = pressing_.surface->pairs;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (const auto& entry : pairs[i].normal.entries) {
      auto& part = parts_[static_cast<std::size_t>(entry.part)];
      const int dof = part.pressed_node[fem::at(entry.dof / components)] * components + entry.dof % components;
      part.load_n[dof] += entry.coefficient * (*pressing_.forces)[i].normal;
      part.area_m2[dof] += entry.coefficient * pairs[i].area_m2;
    }
  }
}

/// Mean over the nodes of a cell that have rows, of the face of a solid over all of its nodes but hanging ones, or 0.
double ShapeRecorder::pressure_pa(const Drawn& part, std::size_t cell) const {
  const int components = fem::components(model_);
  double sum_pa = 0.0;
  int pressed = 0;
  for (const int i : part.cells[cell]) {
    if (i < 0) continue;
    const int first = part.node[fem::at(i)] * components;
    const double area_m2 = part.area_m2.segment(first, components).norm();
    if (area_m2 > 0.0) {
      sum_pa += part.load_n.segment(first, components).norm() / area_m2;
      ++pressed;
    } else if (model_ == fem::Model::solid && !part.hangs[fem::at(i)]) {
      return 0.0;
    }
  }
  return pressed > 0 ? sum_pa / pressed : 0.0;
}

Eigen::Index ShapeRecorder::first_pressure(std::size_t part) const {
  return std::ssize(parts_[part].kept_dof) + std::ssize(parts_[part].element) * numbers_of_plastic(states_[part]);
}

void ShapeRecorder::keep(Series& series, std::int64_t window) {
  if (pressing_.forces && !parts_.empty()) press();
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    auto& part = parts_[p];
    auto& values = part.kept[series.first + series.windows.size()];
    for (std::size_t i = 0; i < part.kept_dof.size(); ++i)
      values[static_cast<Eigen::Index>(i)] = states_[p].u[part.kept_dof[i]];
    if (states_[p].frame) {
      const fem::RigidMotion motion = states_[p].frame->fit(states_[p].u).motion;
      values.tail<numbers_of_frame>() << motion.rotation.reshaped(), motion.to_m - motion.from_m;
    }
    for (std::size_t cell = 0; pressing_.forces && cell < part.cells.size(); ++cell)
      values[first_pressure(p) + static_cast<Eigen::Index>(cell)] = pressure_pa(part, cell);
    if (!states_[p].plastic) continue;
    auto next = static_cast<Eigen::Index>(part.kept_dof.size());
    const int components = states_[p].plastic->components;
    for (const int element : part.element) {
      values.segment(next, components) = states_[p].plastic->stress_of(element);
      values[next + components] = states_[p].plastic->equivalent_of(element);
      if (states_[p].plastic->heats()) values[next + components + 1] = temperature_rise_k(states_[p], element);
      next += numbers_of_plastic(states_[p]);
    }
  }
  series.windows.push_back(window);
}

void ShapeRecorder::finish(std::int64_t window) {
  if (path_.empty()) return;
  if (!run_.windows.empty() && run_.windows.back() == window) run_.windows.pop_back();
  keep(run_, window);
  write();
}

void ShapeRecorder::write() {
  const std::string path = std::exchange(path_, "");
  try {
    if (path.empty() || run_.windows.empty() || !std::filesystem::exists(std::filesystem::path(path).parent_path()))
      return;
    write_atomically(path, text());
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: no picture of its elements in report.html: {}\n", participant_, error.what());
  }
}

std::string ShapeRecorder::text() const {
  const auto all = kept();
  std::vector<std::int64_t> windows;
  std::vector<std::string> times;
  for (const auto& [window, slot] : all) {
    windows.push_back(window);
    times.push_back(fmt::format("{:.17g}", clock_->time_s(window)));
  }
  std::string bodies;
  for (std::size_t p = 0; p < parts_.size(); ++p) bodies.append(p == 0 ? "\n" : ",\n").append(text_of(p, all));
  return fmt::format(
      "{{\"format\": \"ricochet shapes 2\", \"model\": \"{}\", \"largest_window_s\": {:.17g}, \"nose\": {}, "
      "\"uneven\": {}, \"touching\": [{}], \"windows\": [{}], \"times_s\": [{}], \"too_many_cells\": {}, \"bodies\": "
      "[{}]}}\n",
      fem::model_name(model_), clock_->largest_size_s(), nose_, uneven_, fmt::join(touching_bodies_, ", "),
      fmt::join(windows, ", "), fmt::join(times, ", "), too_many_cells_, bodies);
}

std::string ShapeRecorder::text_of(std::size_t part, const std::vector<Kept>& kept) const {
  const auto& drawn = parts_[part];
  const auto& mesh_part = states_[part].part;
  const int components = fem::components(model_);
  const bool yields = states_[part].plastic != nullptr, heats = yields && states_[part].plastic->heats();
  std::vector<std::string> displacements, stresses, plastic_strains, temperature_rises, pressures;
  for (const auto& [window, slot] : kept) {
    const Eigen::VectorXd& values = drawn.kept[slot];
    Eigen::VectorXd u = Eigen::VectorXd::Zero(mesh_part.dofs());
    for (std::size_t i = 0; i < drawn.kept_dof.size(); ++i) u[drawn.kept_dof[i]] = values[static_cast<Eigen::Index>(i)];
    Eigen::VectorXd straining = u;
    if (states_[part].frame) {
      const auto frame = values.tail<numbers_of_frame>();
      const fem::RigidMotion motion{Eigen::Matrix3d(frame.head<9>().reshaped(3, 3)), Eigen::Vector3d::Zero(),
                                    frame.tail<3>()};
      states_[part].frame->straining(u, motion, straining);
    }
    std::vector<float> displacement, stress, plastic_strain, temperature_rise, pressure;
    displacement.reserve(drawn.node.size() * static_cast<std::size_t>(components));
    for (const int node : drawn.node) {
      for (int c = 0; c < components; ++c) displacement.push_back(static_cast<float>(u[node * components + c]));
    }
    stress.reserve(drawn.element.size());
    for (std::size_t i = 0; i < drawn.element.size(); ++i) {
      const int e = drawn.element[i];
      const auto geometry = fem::element_geometry(mesh_part.mesh, e);
      auto tensor = fem::element_stress(mesh_part.section, fem::material_of(mesh_part, e), geometry,
                                        fem::element_displacement(mesh_part.mesh, e, straining),
                                        fem::traits(geometry.kind).centre);
      if (yields) {
        const Eigen::Index at =
            std::ssize(drawn.kept_dof) + numbers_of_plastic(states_[part]) * static_cast<Eigen::Index>(i);
        tensor -= values.segment(at, tensor.size());
        plastic_strain.push_back(static_cast<float>(values[at + tensor.size()]));
        if (heats) temperature_rise.push_back(static_cast<float>(values[at + tensor.size() + 1]));
      }
      stress.push_back(
          static_cast<float>(model_ == fem::Model::bar ? tensor[0] : fem::von_mises_stress(model_, tensor)));
    }
    for (std::size_t cell = 0; pressing_.forces && cell < drawn.cells.size(); ++cell)
      pressure.push_back(static_cast<float>(values[first_pressure(part) + static_cast<Eigen::Index>(cell)]));
    displacements.push_back(packed(displacement));
    pressures.push_back(packed(pressure));
    stresses.push_back(packed(stress));
    plastic_strains.push_back(packed(plastic_strain));
    temperature_rises.push_back(packed(temperature_rise));
  }
  std::vector<int> cells;
  for (const auto& cell : drawn.cells) cells.insert(cells.end(), cell.begin(), cell.end());
  const auto& v = drawn.velocity_m_s;
  const auto more = [](const char* key, const std::vector<std::string>& values, bool told) {
    return told ? fmt::format(",\n\"{}\": [{}]", key, fmt::join(values, ",\n")) : "";
  };
  return fmt::format(
      "{{\"name\": \"{}\", \"strip_m\": {:.9g}, \"initial_velocity_m_s\": [{:.9g}, {:.9g}, {:.9g}],\n\"node\": {},\n"
      "\"position_m\": {},\n\"cell\": {},\n\"displacement_m\": [{}],\n\"stress_pa\": [{}]{}{}{}}}",
      drawn.name, drawn.strip_m, v[0], v[1], v[2], packed(drawn.body_node), packed(drawn.position_m), packed(cells),
      fmt::join(displacements, ",\n"), fmt::join(stresses, ",\n"), more("plastic_strain", plastic_strains, yields),
      more("temperature_rise_k", temperature_rises, heats),
      more("contact_pressure_pa", pressures, pressing_.forces != nullptr));
}

}  // namespace ricochet::solver
