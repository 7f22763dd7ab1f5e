#include "common/body/part_frame.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "common/body/blocks.hpp"
#include "common/body/other_ranks.hpp"
#include "common/body/outer_sums.hpp"

namespace ricochet::solver {
namespace {

/// Nodes that a thread takes at a time: whole blocks.
constexpr int stretch_nodes = 64 * block_nodes;

/// work(stretch, first node, last node) of each stretch of the nodes.
template <class Work>
void for_each_stretch(int nodes, Parallel* parallel, const Work& work) {
  const int stretches = (nodes + stretch_nodes - 1) / stretch_nodes;
  const auto one = [&](int stretch, int) noexcept {
    work(stretch, stretch * stretch_nodes, std::min((stretch + 1) * stretch_nodes, nodes));
  };
  if (parallel != nullptr && stretches > 1) {
    parallel->for_each(stretches, one);
  } else {
    for (int stretch = 0; stretch < stretches; ++stretch) one(stretch, 0);
  }
}

Eigen::Vector2d turned(const Eigen::Vector3d& by, const Eigen::Vector2d& a) { return {-by[2] * a[1], by[2] * a[0]}; }
Eigen::Vector3d turned(const Eigen::Vector3d& by, const Eigen::Vector3d& a) { return by.cross(a); }

}  // namespace

Eigen::Matrix3d rotation_of(const Eigen::Matrix2d& h) {
  const double cosine = h(0, 0) + h(1, 1), sine = h(1, 0) - h(0, 1), size = std::hypot(cosine, sine);
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (size > 0.0) rotation.topLeftCorner<2, 2>() << cosine / size, -sine / size, sine / size, cosine / size;
  return rotation;
}
Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& h) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(h, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if (u.determinant() * svd.matrixV().determinant() < 0.0) u.col(2) *= -1.0;
  return u * svd.matrixV().transpose();
}

PartFrame::PartFrame(const fem::Part& part) : components_(fem::components(part.mesh.model)), mass_(part.lumped_mass) {
  if (part.mesh.model != fem::Model::plane_strain && part.mesh.model != fem::Model::solid)
    throw std::invalid_argument("only bodies in plane strain and solids turn");
  for (int node = 0; node < part.nodes(); ++node) {
    whole_.mass_kg += mass_[node];
    whole_.centre_m += mass_[node] * part.mesh.position[fem::at(node)];
  }
  whole_.centre_m /= whole_.mass_kg;
  set_arms(part);
  for (int node = 0; node < part.nodes(); ++node) {
    const Eigen::Vector3d arm = part.mesh.position[fem::at(node)] - whole_.centre_m;
    whole_.inertia_kg_m2 += mass_[node] * arm * arm.transpose();
  }
}

PartFrame::PartFrame(const fem::Part& share, const Whole& whole, OtherRanks& others)
    : components_(fem::components(share.mesh.model)), whole_(whole), others_(&others), mass_(share.lumped_mass) {
  set_arms(share);
}

void PartFrame::set_arms(const fem::Part& part) {
  arm_.resize(part.dofs());
  for (int node = 0; node < part.nodes(); ++node) {
    const Eigen::Vector3d arm = part.mesh.position[fem::at(node)] - whole_.centre_m;
    for (int c = 0; c < components_; ++c) arm_[node * components_ + c] = arm[c];
  }
}

/// Adds up sum_of(first node, last node), block after block: the same bits for any number of threads and ranks.
template <class Sum, class SumOf>
Sum PartFrame::sum_of_blocks(Parallel* parallel, const SumOf& sum_of) const {
  const auto nodes = static_cast<int>(mass_.size());
  const auto of_block = [&](int block) -> Sum {
    return sum_of(block * block_nodes, std::min((block + 1) * block_nodes, nodes));
  };
  Sum all = Sum::Zero();
  if (others_ != nullptr) {
    others_->sum(
        static_cast<int>(Sum::SizeAtCompileTime),
        [&](int block, double* numbers) {
          const Sum sum = of_block(block);
          std::copy_n(sum.data(), sum.size(), numbers);
        },
        all.data());
    return all;
  }
  std::vector<Sum> sums(static_cast<std::size_t>(blocks_of(nodes)));
  for_each_stretch(nodes, parallel, [&](int, int first, int last) {
    for (int block = first / block_nodes; block < blocks_of(last); ++block)
      sums[static_cast<std::size_t>(block)] = of_block(block);
  });
  for (const Sum& sum : sums) all += sum;
  return all;
}

template <int components>
PartFrame::Fit PartFrame::fit_of(const Eigen::VectorXd& u, Parallel* parallel) const {
  using Matrix = Eigen::Matrix<double, components, components>;
  using Sums = Eigen::Matrix<double, components, components + 1>;  // sum m u Y^T, sum m u
  const double *const moved = u.data(), *const mass = mass_.data(), *const arm = arm_.data();
  const Sums all = sum_of_blocks<Sums>(parallel, [=](int first, int last) {
    return outer_sums<components, components + 1>(
        first, last, [=](int node, int c) { return moved[node * components + c]; },
        [=](int node, int c) { return mass[node] * (c < components ? arm[node * components + c] : 1.0); });
  });
  const Matrix turned = all.template leftCols<components>(),
               h = whole_.inertia_kg_m2.topLeftCorner<components, components>() + turned;
  Fit fit;
  if (!turned.isZero(0.0)) fit.motion.rotation = rotation_of(h);  // else rounding would strain a body at rest
  fit.motion.from_m = fit.motion.to_m = whole_.centre_m;
  fit.motion.to_m.head<components>() += all.col(components) / whole_.mass_kg;
  fit.stretch.setZero();
  const Matrix stretch = fit.motion.rotation.topLeftCorner<components, components>().transpose() * h;
  fit.stretch.topLeftCorner<components, components>() = 0.5 * (stretch + stretch.transpose());
  return fit;
}

PartFrame::Fit PartFrame::fit(const Eigen::VectorXd& u, Parallel* parallel) const {
  Fit fit = components_ == 2 ? fit_of<2>(u, parallel) : fit_of<3>(u, parallel);
  if (others_ != nullptr) last_ = fit;
  return fit;
}

template <int components>
void PartFrame::straining_of(const Eigen::VectorXd& u, const fem::RigidMotion& motion, Eigen::VectorXd& d,
                             Parallel* parallel) const {
  using Vector = Eigen::Matrix<double, components, 1>;
  using Matrix = Eigen::Matrix<double, components, components>;
  const Matrix back = motion.rotation.topLeftCorner<components, components>().transpose(),
               change = back - Matrix::Identity();
  const Vector moved = (motion.to_m - motion.from_m).head<components>();
  d.resize(u.size());
  const double *const of_u = u.data(), *const of_arm = arm_.data();
  double* const of_d = d.data();
  for_each_stretch(static_cast<int>(mass_.size()), parallel, [=](int, int first, int last) {
    for (int dof = first * components; dof < last * components; dof += components) {
      const Vector at = Eigen::Map<const Vector>(of_u + dof) - moved;
      Eigen::Map<Vector>(of_d + dof) =
          change.lazyProduct(Eigen::Map<const Vector>(of_arm + dof)) + back.lazyProduct(at);
    }
  });
}

void PartFrame::straining(const Eigen::VectorXd& u, const fem::RigidMotion& motion, Eigen::VectorXd& d,
                          Parallel* parallel) const {
  components_ == 2 ? straining_of<2>(u, motion, d, parallel) : straining_of<3>(u, motion, d, parallel);
}

Eigen::VectorXd PartFrame::straining(const Eigen::VectorXd& u) const {
  Eigen::VectorXd d;
  straining(u, fit(u).motion, d);
  return d;
}

namespace {
template <int components>
void turn_each(const Eigen::Matrix3d& by, Eigen::VectorXd& of_nodes) {
  const Eigen::Matrix<double, components, components> turn = by.topLeftCorner<components, components>();
  for (Eigen::Index dof = 0; dof < of_nodes.size(); dof += components)
    of_nodes.segment<components>(dof) = turn * of_nodes.segment<components>(dof);
}
}  // namespace

void turn_nodes(const Eigen::Matrix3d& by, int components, Eigen::VectorXd& of_nodes) {
  components == 2 ? turn_each<2>(by, of_nodes) : turn_each<3>(by, of_nodes);
}

template <int components>
void PartFrame::force_of(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
                         Parallel* parallel) const {
  using Vector = Eigen::Matrix<double, components, 1>;
  using Matrix = Eigen::Matrix<double, components, components>;
  const auto nodes = static_cast<int>(mass_.size());
  const double *const of_d = d.data(), *const of_g = g.data(), *const of_arm = arm_.data(), *const mass = mass_.data();
  const Eigen::Vector3d moment = turning_part(sum_of_blocks<Matrix>(parallel, [=](int first, int last) {
    return outer_sums<components, components>(
        first, last, [=](int node, int c) { return of_arm[node * components + c] + of_d[node * components + c]; },
        [=](int node, int c) { return of_g[node * components + c]; });
  }));
  Eigen::Matrix3d spread = fit.stretch.trace() * Eigen::Matrix3d::Identity() - fit.stretch;
  if (components == 2) spread.topLeftCorner<2, 2>().setIdentity();  // nothing turns about these axes
  const Eigen::Vector3d c = spread.inverse() * moment;
  const Matrix rotation = fit.motion.rotation.topLeftCorner<components, components>();
  p.resize(g.size());
  double* const of_p = p.data();
  for_each_stretch(nodes, parallel, [=](int, int first, int last) {
    for (int node = first; node < last; ++node) {
      const int dof = node * components;
      const Vector arm = Eigen::Map<const Vector>(of_arm + dof);
      const Vector pulled = Eigen::Map<const Vector>(of_g + dof) - mass[node] * turned(c, arm);
      Eigen::Map<Vector>(of_p + dof) = rotation.lazyProduct(pulled);
    }
  });
}

void PartFrame::force(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
                      Parallel* parallel) const {
  components_ == 2 ? force_of<2>(fit, d, g, p, parallel) : force_of<3>(fit, d, g, p, parallel);
}

namespace {
/// sum d_i P_i^T.
template <int components>
Eigen::Matrix3d strained_by(const Eigen::VectorXd& d, const Eigen::VectorXd& force, int first, int last) {
  const double *const of_d = d.data(), *const of_force = force.data();
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  sum.topLeftCorner<components, components>() = outer_sums<components, components>(
      first, last, [=](int node, int c) { return of_d[node * components + c]; },
      [=](int node, int c) { return of_force[node * components + c]; });
  return sum;
}
}  // namespace

double PartFrame::work_of(const Eigen::Matrix3d& rotation, const Eigen::VectorXd& d, const Eigen::VectorXd& p,
                          int block) const {
  const int first = block * block_nodes, last = std::min(first + block_nodes, static_cast<int>(mass_.size()));
  const Eigen::Matrix3d sum = components_ == 2 ? strained_by<2>(d, p, first, last) : strained_by<3>(d, p, first, last);
  return rotation.cwiseProduct(sum.transpose()).sum();
}

}  // namespace ricochet::solver
