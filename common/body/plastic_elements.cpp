#include "common/body/plastic_elements.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/fem/element_copies.hpp"

namespace ricochet::solver {
namespace {

constexpr std::size_t elements_of_block = 32;
/// Rounding must not let a point pass its yield stress unseen.
constexpr double caution = 1.001;

}  // namespace

PlasticElements::PlasticElements(const BodyState& state)
    : state_(&state),
      law_(*state.part.material.plasticity),
      factor_squared_(state.part.section.model == fem::Model::bar ? 1.0 : 1.5),
      all_{{0, state.part.dofs()}},
      settled_(state.plastic),
      step_(*settled_) {
  set_shapes();
  set_blocks();
  u_settled_ = u_step_ = state.u;
}

void PlasticElements::set_shapes() {
  const auto& part = state_->part;
  fem::ElementCopies<int> copies(part.section.model);
  // In axisymmetry u_r moves a strain by its gradient and by itself.
  const double times = part.section.model == fem::Model::axisymmetric ? std::sqrt(2.0) : 1.0;
  const double scale = caution * times * std::sqrt(factor_squared_) * settled_->modulus_pa;
  const auto make = [&](const fem::ElementGeometry& geometry) {
    Shape& shape = shapes_.emplace_back();
    shape.points = fem::element_points(part.section, geometry);
    for (const auto& point : shape.points)
      shape.pa_per_m = std::max(shape.pa_per_m, scale * point.gradient.rowwise().norm().sum());
    return static_cast<int>(shapes_.size()) - 1;
  };
  for (int e = 0; e < static_cast<int>(part.mesh.elements.size()); ++e)
    shape_of_.push_back(copies.of(fem::element_geometry(part.mesh, e), make));
}

void PlasticElements::set_blocks() {
  const auto& elements = state_->part.mesh.elements;
  due_m_.assign(elements.size(), 0.0);
  for (std::size_t first = 0; first < elements.size(); first += elements_of_block) {
    const std::size_t end = std::min(elements.size(), first + elements_of_block);
    Block& block = blocks_.emplace_back();
    block.first = static_cast<int>(first);
    block.end = static_cast<int>(end);
    for (std::size_t e = first; e < end; ++e)
      block.nodes.insert(block.nodes.end(), elements[e].begin(), elements[e].end());
    std::sort(block.nodes.begin(), block.nodes.end());
    block.nodes.erase(std::unique(block.nodes.begin(), block.nodes.end()), block.nodes.end());
  }
}

PlasticElements::Strain PlasticElements::plastic_strain(int point) const {
  Strain strain = Strain::Zero();
  for (int c = 0; c < step_.components; ++c) strain[c] = step_.strain[Eigen::Index{point} * step_.components + c];
  return strain;
}

/// Relative to the first node, so that the distance that a body has flown is not rounded into its strain; u_r counts as
/// it is.
template <int dimension>
PlasticElements::Strain PlasticElements::stress_of(int element, int point, const Eigen::VectorXd& u) const {
  const auto& nodes = state_->part.mesh.elements[fem::at(element)];
  const auto& gradient = shapes_[fem::at(shape_of_[fem::at(element)])].points[fem::at(point)].gradient;
  const bool round = state_->part.section.model == fem::Model::axisymmetric;
  Eigen::Matrix<double, dimension, dimension> sum = Eigen::Matrix<double, dimension, dimension>::Zero();
  double hoop = 0.0;
  const Eigen::Matrix<double, dimension, 1> first = u.segment<dimension>(dimension * nodes[0]);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const Eigen::Matrix<double, dimension, 1> own = u.segment<dimension>(dimension * nodes[i]);
    if (i > 0) sum.noalias() += (own - first) * gradient.row(row).template head<dimension>();
    if (round) hoop += own[0] * gradient(row, 2);
  }
  Strain strain = Strain::Zero();
  if constexpr (dimension == 1) {
    strain[0] = sum(0, 0);
  } else {
    strain[2] = hoop;
    strain.template head<dimension>() = sum.diagonal();
    strain.template head<3>().array() -= strain.template head<3>().mean();
    const double shear = std::sqrt(0.5);
    strain[3] = shear * (sum(0, 1) + sum(1, 0));
    if constexpr (dimension == 3) {
      strain[4] = shear * (sum(1, 2) + sum(2, 1));
      strain[5] = shear * (sum(2, 0) + sum(0, 2));
    }
  }
  return step_.modulus_pa * (strain - plastic_strain(element * step_.points + point));
}

/// s at a point if it does not yield any further.
PlasticElements::Strain PlasticElements::stress(int element, int point, const Eigen::VectorXd& u) const {
  switch (fem::components(state_->part.section.model)) {
    case 1: return stress_of<1>(element, point, u);
    case 2: return stress_of<2>(element, point, u);
    default: return stress_of<3>(element, point, u);
  }
}

double PlasticElements::softening(int point) const {
  return step_.heats() ? law_.heat->softening(step_.temperature_k[point]) : 1.0;
}

/// How far its points are from yielding, 0 where one does, and what flows [Pa].
double PlasticElements::margin(int element, const Eigen::VectorXd& u, std::vector<Flow>& flows) const {
  double smallest = std::numeric_limits<double>::infinity();
  const double to_yield = step_.modulus_pa * factor_squared_;
  for (int p = 0; p < step_.points; ++p) {
    const int point = element * step_.points + p;
    const Strain s = stress(element, p, u);
    const double q = std::sqrt(factor_squared_) * s.norm();
    const double equivalent = step_.equivalent[point], soft = softening(point);
    const double excess_pa = q - law_.at_rest(equivalent, soft);
    smallest = std::min(smallest, std::max(0.0, -excess_pa));
    if (!(excess_pa > 0.0)) continue;
    const double grown = law_.growth(q, to_yield, equivalent, soft, tried_s_);
    flows.push_back({element, point, grown, factor_squared_ * grown / q, s});
  }
  return smallest;
}

/// Half of what lies between the least and the most that nodes have moved is how far one can be from where the
/// translation of all would have brought it. No translation leaves u_r without a strain.
double PlasticElements::moved(const Block& block, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  const auto model = state_->part.section.model;
  const int width = fem::components(model);
  double squared = 0.0;
  for (int c = 0; c < width; ++c) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const int node : block.nodes) {
      const int dof = node * width + c;
      const double own = to[dof] - from[dof];
      least = std::min(least, own);
      most = std::max(most, own);
    }
    const bool round = c == 0 && model == fem::Model::axisymmetric;
    const double far = round ? std::max(std::abs(least), std::abs(most)) : 0.5 * (most - least);
    squared += far * far;
  }
  return std::sqrt(squared);
}

void PlasticElements::look(Block& block, const Eigen::VectorXd& u) {
  block.flows.clear();
  block.tried_m = moved(block, u_step_, u);
  if (block.path_m + block.tried_m < block.due_m) return;
  block.due_m = std::numeric_limits<double>::infinity();
  for (int e = block.first; e < block.end; ++e) {
    double& due_m = due_m_[fem::at(e)];
    if (block.path_m + block.tried_m >= due_m) {
      const double margin_m = margin(e, u, block.flows) / shapes_[fem::at(shape_of_[fem::at(e)])].pa_per_m;
      due_m = block.path_m + std::max(0.0, margin_m - block.tried_m);
    }
    block.due_m = std::min(block.due_m, due_m);
  }
}

void PlasticElements::look(const Eigen::VectorXd& u) {
  u_tried_ = u;
  const auto blocks = static_cast<int>(blocks_.size());
  const auto look_at = [&](int b, int) noexcept { look(blocks_[fem::at(b)], u_tried_); };
  if (state_->parallel) {
    state_->parallel->for_each(blocks, look_at);
  } else {
    for (int b = 0; b < blocks; ++b) look_at(b, 0);
  }
}

/// force += integral of B^T m (change of plastic strain) dV at the point.
void PlasticElements::add_force(const Flow& flow, Eigen::VectorXd& force) const {
  const auto& point = shapes_[fem::at(shape_of_[fem::at(flow.element)])].points[fem::at(flow.point % step_.points)];
  const auto model = state_->part.section.model;
  const int width = fem::components(model);
  const Strain stress = (step_.modulus_pa * point.volume_m3) * flow.strain();
  const double shear = std::sqrt(0.5);
  Eigen::Matrix3d tensor;
  tensor << stress[0], shear * stress[3], shear * stress[5],  //
      shear * stress[3], stress[1], shear * stress[4],        //
      shear * stress[5], shear * stress[4], stress[2];
  const auto& nodes = state_->part.mesh.elements[fem::at(flow.element)];
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    Eigen::Vector3d gradient = point.gradient.row(static_cast<Eigen::Index>(i));
    if (model == fem::Model::axisymmetric) force[2 * nodes[i]] += stress[2] * std::exchange(gradient[2], 0.0);
    const Eigen::Vector3d own = tensor * gradient;
    for (int c = 0; c < width; ++c) force[nodes[i] * width + c] += own[c];
  }
}

void PlasticElements::evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  state_->stiffness.multiply(u, force);
  tried_s_ = step_s;
  look(u);
  tried_force_n_ = step_.force_n;
  for (const Block& block : blocks_)
    for (const Flow& flow : block.flows) add_force(flow, tried_force_n_);
  force -= tried_force_n_;
}

void PlasticElements::heat(int point, double work_j_m3) {
  double& temperature_k = step_.temperature_k[point];
  temperature_k += law_.heat->fraction * work_j_m3 / law_.heat->capacity_j_m3_k;
  step_.hottest_k = std::max(step_.hottest_k, temperature_k);
}

void PlasticElements::follow(const Eigen::VectorXd&) {
  const double modulus_pa = step_.modulus_pa;
  bool flowed = false;
  for (Block& block : blocks_) {
    for (const Flow& flow : block.flows) {
      const int p = flow.point % step_.points;
      const double volume = shapes_[fem::at(shape_of_[fem::at(flow.element)])].points[fem::at(p)].volume_m3;
      const Strain change = flow.strain(), before = stress(flow.element, p, u_step_),
                   after = flow.stress - modulus_pa * change;
      const double work_j_m3 = 0.5 * (before + after).dot(change);
      step_.work_j += volume * work_j_m3;
      if (step_.heats()) heat(flow.point, work_j_m3);
      step_.energy_j += volume * modulus_pa * (plastic_strain(flow.point) + 0.5 * change).dot(change);
      for (int c = 0; c < step_.components; ++c) step_.at(flow.point)[c] += change[c];
      step_.equivalent[flow.point] += flow.equivalent;
      step_.largest = std::max(step_.largest, step_.equivalent[flow.point]);
      changed_.push_back(flow.point);
    }
    flowed = flowed || !block.flows.empty();
    block.flows.clear();
    block.path_m += std::exchange(block.tried_m, 0.0);
  }
  if (flowed) step_.force_n = tried_force_n_;
  u_step_ = u_tried_;
}

namespace {

/// `to` becomes `from`, which differs in these points at most.
void take(const std::vector<int>& points, const PlasticState& from, PlasticState& to) {
  if (points.empty()) return;
  for (const int point : points) {
    to.at(point) = from.at(point);
    to.equivalent[point] = from.equivalent[point];
    if (to.heats()) to.temperature_k[point] = from.temperature_k[point];
  }
  to.force_n = from.force_n;
  to.energy_j = from.energy_j;
  to.work_j = from.work_j;
  to.largest = from.largest;
  to.hottest_k = from.hottest_k;
}

}  // namespace

void PlasticElements::settle() {
  take(changed_, step_, *settled_);
  changed_.clear();
  u_settled_ = u_step_;
}

void PlasticElements::go_back() {
  take(changed_, *settled_, step_);
  for (const int point : changed_) {
    const auto element = fem::at(point / step_.points);
    due_m_[element] = blocks_[element / elements_of_block].due_m = 0.0;
  }
  changed_.clear();
  for (Block& block : blocks_) block.path_m += moved(block, u_step_, u_settled_);
  u_step_ = u_settled_;
}

/// u . K u/2 - u . force + integral of m/2 p : p dV, and u . P = u . K u - u . force.
double PlasticElements::stored(const Eigen::VectorXd& u, const Eigen::VectorXd&, double half_work_j) const {
  return half_work_j - 0.5 * u.dot(settled_->force_n) + settled_->energy_j;
}

void PlasticElements::archive(Archive& a) {
  a(*settled_);
  a.same_size(u_settled_);
  if (!a.reading()) return;
  step_ = *settled_;
  u_step_ = u_settled_;
  std::fill(due_m_.begin(), due_m_.end(), 0.0);
  for (Block& block : blocks_) block.due_m = 0.0;
}

}  // namespace ricochet::solver
