#include "common/body/plastic_elements.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace ricochet::solver {
namespace {

/// Points that flow, and as much other work, from which on threads pay: some twenty microseconds of work.
constexpr std::size_t worth_a_thread = 1000;
/// Elements hold enough where the stress misses the yield stress by no more than the first share of it, or where the
/// flow misses its value by no more than the second share and the stress by no more than the third. The next step makes
/// up for missing flow; needless flow stays.
constexpr double enough_of_yield = 1e-3, enough_of_flow = 0.03, most_of_yield = 0.03;

}  // namespace

/// s at all points of an element if they do not yield any further; a row per component. The displacement of the nodes
/// counts from the first one's, so that the distance that a body has flown is not rounded into its strain; u_r counts
/// as it is.
template <int dimension>
auto PlasticElements::stresses(int element, const Eigen::VectorXd& u) const -> Stresses<dimension> {
  using AtPoints = Eigen::Array<double, points_of<dimension>, 1>;
  const auto& nodes = state_->part.mesh.elements[fem::at(element)];
  const double* gradient = shapes_[fem::at(shape_of_[fem::at(element)])].gradients.data();
  const double* const first = u.data() + std::ptrdiff_t{dimension} * nodes[0];
  std::array<std::array<AtPoints, dimension>, dimension> sum;
  for (auto& row : sum)
    for (AtPoints& value : row) value.setZero();
  AtPoints hoop = AtPoints::Zero();
  for (const int node : nodes) {
    const double* const own = u.data() + std::ptrdiff_t{dimension} * node;
    for (std::size_t d = 0; d < 3; ++d, gradient += points_of<dimension>) {
      const AtPoints along = Eigen::Map<const AtPoints>(gradient);
      if (d < dimension)
        for (std::size_t c = 0; c < dimension; ++c) sum[c][d] += (own[c] - first[c]) * along;
      if (dimension == 2 && d == 2 && round_) hoop += own[0] * along;
    }
  }
  Stresses<dimension> s;
  if constexpr (dimension == 1) {
    s.row(0) = sum[0][0];
  } else {
    const double shear = std::sqrt(0.5);
    const AtPoints third = dimension == 3 ? sum[2 % dimension][2 % dimension] : hoop;
    const AtPoints mean = (sum[0][0] + sum[1][1] + third) / 3.0;
    s.row(0) = sum[0][0] - mean;
    s.row(1) = sum[1][1] - mean;
    s.row(2) = third - mean;
    s.row(3) = shear * (sum[0][1] + sum[1][0]);
    if constexpr (dimension == 3) {
      s.row(4) = shear * (sum[1][2] + sum[2][1]);
      s.row(5) = shear * (sum[2][0] + sum[0][2]);
    }
  }
  const double* const plastic = step_.strain.data() + Stresses<dimension>::SizeAtCompileTime * std::ptrdiff_t{element};
  using ByPoint = Eigen::Array<double, components_of<dimension>, points_of<dimension>>;
  return step_.modulus_pa(element) * (s - Eigen::Map<const ByPoint>(plastic));
}

double PlasticElements::softening(const fem::Plasticity& law, int point) const {
  return law.heat ? law.heat->softening(step_.temperature_k[point]) : 1.0;
}

/// How far its points are from yielding, 0 where one does, and what flows [Pa].
template <int dimension>
double PlasticElements::margin(int element, const Eigen::VectorXd& u, std::vector<Flow>& flows) const {
  double smallest = std::numeric_limits<double>::infinity();
  const fem::Plasticity& own = law(element);
  const double to_yield = step_.modulus_pa(element) * factor_squared_;
  const Stresses<dimension> s = stresses<dimension>(element, u);
  const Eigen::Array<double, 1, points_of<dimension>> q = (factor_squared_ * s.square().colwise().sum()).sqrt();
  for (int p = 0; p < points_of<dimension>; ++p) {
    const int point = element * points_of<dimension> + p;
    const double equivalent = step_.equivalent[point], soft = softening(own, point);
    const double rest_pa = own.at_rest(equivalent, soft);
    smallest = std::min(smallest, std::max(0.0, rest_pa - q[p]));
    if (!(q[p] > rest_pa)) continue;
    const double grown = own.growth(q[p], rest_pa, to_yield, equivalent, soft, tried_s_);
    Flow& flow = flows.emplace_back(Flow{element, point, grown, factor_squared_ * grown / q[p], Strain::Zero()});
    flow.stress.template head<components_of<dimension>>() = s.col(p).matrix();
  }
  return smallest;
}

/// Half of what lies between the least and the most that nodes have moved is how far one can be from where the
/// translation of all would have brought it. No translation leaves u_r without a strain.
double PlasticElements::moved(const Block& block, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  const int width = fem::components(state_->part.section.model);
  double squared = 0.0;
  for (int c = 0; c < width; ++c) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const int node : block.nodes) {
      const int dof = node * width + c;
      const double own = to[dof] - from[dof];
      least = std::min(least, own);
      most = std::max(most, own);
    }
    const double far = c == 0 && round_ ? std::max(std::abs(least), std::abs(most)) : 0.5 * (most - least);
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
      const double margin_pa = by_dimension([&](auto d) { return margin<d()>(e, u, block.flows); });
      const double margin_m = margin_pa / shapes_[fem::at(shape_of_[fem::at(e)])].pa_per_m;
      due_m = block.path_m + std::max(0.0, margin_m - block.tried_m);
    }
    block.due_m = std::min(block.due_m, due_m);
  }
}

template <class Visit>
void PlasticElements::for_blocks(const Visit& visit) {
  const auto blocks = static_cast<int>(blocks_.size());
  const auto visit_one = [&](int b, int) noexcept { visit(blocks_[fem::at(b)]); };
  const std::size_t work = flowing_ + state_->part.mesh.elements.size() / 16;
  if (state_->parallel && work >= worth_a_thread) {
    state_->parallel->for_each(blocks, visit_one);
  } else {
    for (int b = 0; b < blocks; ++b) visit_one(b, 0);
  }
}

void PlasticElements::look(const Eigen::VectorXd& u) {
  u_tried_ = u;
  for_blocks([&](Block& block) { look(block, u_tried_); });
  flowing_ = 0;
  for (const Block& block : blocks_) flowing_ += block.flows.size();
}

/// force += integral of B^T m (change of plastic strain) dV at the point.
template <int dimension>
void PlasticElements::add_force(const Flow& flow, Eigen::VectorXd& force) const {
  const Shape& shape = shapes_[fem::at(shape_of_[fem::at(flow.element)])];
  const int point = flow.point % points_of<dimension>;
  const double shear = std::sqrt(0.5);
  const Strain s = (step_.modulus_pa(flow.element) * shape.volume_m3[fem::at(point)]) * flow.strain();
  const double tensor[3][3] = {
      {s[0], shear * s[3], shear * s[5]}, {shear * s[3], s[1], shear * s[4]}, {shear * s[5], shear * s[4], s[2]}};
  const double* gradient = shape.gradients.data() + point;
  for (const int node : state_->part.mesh.elements[fem::at(flow.element)]) {
    double* const own = force.data() + std::ptrdiff_t{dimension} * node;
    for (int c = 0; c < dimension; ++c)
      for (int d = 0; d < dimension; ++d) own[c] += tensor[c][d] * gradient[d * points_of<dimension>];
    if (dimension == 2 && round_) own[0] += s[2] * gradient[2 * points_of<dimension>];
    gradient += 3 * points_of<dimension>;
  }
}

/// Finds the flow of a step to u, and its force.
void PlasticElements::return_at(double step_s, const Eigen::VectorXd& u) {
  tried_s_ = step_s;
  look(u);
  tried_force_n_ = step_.force_n;
  by_dimension([&](auto d) {
    for (const Block& block : blocks_)
      for (const Flow& flow : block.flows) add_force<d()>(flow, tried_force_n_);
  });
}

void PlasticElements::evaluate(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& force) {
  if (state_->others != nullptr && state_->part.mesh.hanging.empty() && !state_->frame) state_->others->exchange(u);
  state_->stiffness.multiply(u, force);
  if (held_) {
    u_tried_ = u;
  } else {
    return_at(step_s, u);
  }
  force -= tried_force_n_;
}

void PlasticElements::evaluate_at_rest(Eigen::VectorXd& u, Eigen::VectorXd& force) {
  state_->stiffness.multiply(u, force);
  force -= step_.force_n;
}

void PlasticElements::hold(double step_s, Eigen::VectorXd& u, Eigen::VectorXd& change) {
  return_at(step_s, u);
  held_ = true;
  change = tried_force_n_ - step_.force_n;
}

/// Whether what its points hold is what flows in a step to u.
template <int dimension>
bool PlasticElements::holds_enough(const Block& block, const Eigen::VectorXd& u, double path_m) const {
  auto flow = block.flows.begin();
  for (int e = block.first; e < block.end; ++e) {
    if ((flow == block.flows.end() || flow->element != e) && path_m < due_m_[fem::at(e)]) continue;
    const Stresses<dimension> s = stresses<dimension>(e, u);
    const double to_yield = step_.modulus_pa(e) * factor_squared_;
    const Eigen::Array<double, 1, points_of<dimension>> q = (factor_squared_ * s.square().colwise().sum()).sqrt();
    for (int p = 0; p < points_of<dimension>; ++p) {
      const int point = e * points_of<dimension> + p;
      const bool flows = flow != block.flows.end() && flow->point == point;
      const double held = flows ? (flow++)->equivalent : 0.0;
      const double equivalent = step_.equivalent[point], soft = softening(law(e), point);
      const double rest_pa = law(e).at_rest(equivalent, soft);
      const double due = q[p] > rest_pa ? law(e).growth(q[p], rest_pa, to_yield, equivalent, soft, tried_s_) : 0.0;
      const double enough_pa =
          std::clamp(enough_of_flow * due * to_yield, enough_of_yield * rest_pa, most_of_yield * rest_pa);
      if (std::abs(held - due) * to_yield > enough_pa) return false;
    }
  }
  return true;
}

bool PlasticElements::hold_enough(Eigen::VectorXd& u) {
  std::atomic<bool> enough = true;
  for_blocks([&](Block& block) {
    if (!enough) return;
    const double path_m = block.path_m + moved(block, u_step_, u);
    if (block.flows.empty() && path_m < block.due_m) return;
    if (!by_dimension([&](auto d) { return holds_enough<d()>(block, u, path_m); })) enough = false;
  });
  return enough;
}

void PlasticElements::heat(const fem::Plasticity& law, int point, double work_j_m3) {
  double& temperature_k = step_.temperature_k[point];
  temperature_k += law.heat->fraction * work_j_m3 / law.heat->capacity_j_m3_k;
  step_.hottest_k = std::max(step_.hottest_k, temperature_k);
}

template <int dimension>
void PlasticElements::keep(const std::vector<Flow>& flows) {
  Stresses<dimension> before_step = Stresses<dimension>::Zero(), after_step = before_step;
  int element = -1;
  for (const Flow& flow : flows) {
    const int p = flow.point % points_of<dimension>;
    if (flow.element != element) {
      element = flow.element;
      before_step = stresses<dimension>(element, u_step_);
      if (held_) after_step = stresses<dimension>(element, u_tried_);
    }
    const double modulus_pa = step_.modulus_pa(flow.element);
    const double volume = shapes_[fem::at(shape_of_[fem::at(flow.element)])].volume_m3[fem::at(p)];
    const Strain change = flow.strain();
    Strain after = flow.stress;
    if (held_) after.template head<components_of<dimension>>() = after_step.col(p).matrix();
    after -= modulus_pa * change;
    double* const plastic = step_.strain.data() + std::ptrdiff_t{components_of<dimension>} * flow.point;
    double work_j_m3 = 0.0, energy_j_m3 = 0.0;
    for (int c = 0; c < components_of<dimension>; ++c) {
      work_j_m3 += 0.5 * (before_step(c, p) + after[c]) * change[c];
      energy_j_m3 += (plastic[c] + 0.5 * change[c]) * change[c];
      plastic[c] += change[c];
    }
    const int block = PlasticState::block_of(state_->part, flow.element);
    step_.work_j[block] += volume * work_j_m3;
    if (const fem::Plasticity& own = law(flow.element); own.heat) heat(own, flow.point, work_j_m3);
    step_.energy_j[block] += volume * modulus_pa * energy_j_m3;
    step_.equivalent[flow.point] += flow.equivalent;
    step_.largest = std::max(step_.largest, step_.equivalent[flow.point]);
    changed_.push_back(flow.point);
  }
}

void PlasticElements::follow(const Eigen::VectorXd&) {
  bool flowed = false;
  for (Block& block : blocks_) {
    if (held_) block.tried_m = moved(block, u_step_, u_tried_);
    by_dimension([&](auto d) { keep<d()>(block.flows); });
    flowed = flowed || !block.flows.empty();
    block.flows.clear();
    block.path_m += std::exchange(block.tried_m, 0.0);
  }
  if (flowed) step_.force_n = tried_force_n_;
  u_step_ = u_tried_;
  held_ = false;
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
  held_ = false;
  for (const int point : changed_) {
    const auto element = fem::at(point / step_.points);
    due_m_[element] = blocks_[element / elements_of_block].due_m = 0.0;
  }
  changed_.clear();
  for (Block& block : blocks_) block.path_m += moved(block, u_step_, u_settled_);
  u_step_ = u_settled_;
}

double PlasticElements::stored(const Eigen::VectorXd& u, const Eigen::VectorXd&, double half_work_j) const {
  const int width = fem::components(state_->part.section.model);
  double beyond_j = 0.0;
  for (int block = 0; block < settled_->energy_j.size(); ++block)
    beyond_j += settled_->stored_beyond_j(u, block, width);
  return half_work_j + beyond_j;
}

void PlasticElements::archive(Archive& a) {
  a(*settled_);
  a.same_size(u_settled_);
  if (!a.reading()) return;
  step_ = *settled_;
  u_step_ = u_settled_;
  held_ = false;
  std::fill(due_m_.begin(), due_m_.end(), 0.0);
  for (Block& block : blocks_) block.due_m = 0.0;
}

}  // namespace ricochet::solver
