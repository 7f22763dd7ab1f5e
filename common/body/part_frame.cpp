#include "common/body/part_frame.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "common/body/blocks.hpp"

namespace ricochet::solver {
namespace {

/// work(block, first node, last node) of each block. Threads take many at a time: one takes less than handing it out.
template <class Work>
void for_each_block(int nodes, Parallel* parallel, const Work& work) {
  constexpr int at_a_time = 64;
  const int blocks = blocks_of(nodes);
  const auto some = [&](int part, int) noexcept {
    for (int block = part * at_a_time; block < std::min((part + 1) * at_a_time, blocks); ++block)
      work(block, block * block_nodes, std::min((block + 1) * block_nodes, nodes));
  };
  const int parts = (blocks + at_a_time - 1) / at_a_time;
  if (parallel != nullptr && parts > 1) {
    parallel->for_each(parts, some);
  } else {
    for (int part = 0; part < parts; ++part) some(part, 0);
  }
}

template <int components>
Eigen::Matrix<double, components, 1> at_node(const Eigen::VectorXd& x, int node) {
  return x.segment<components>(node * components);
}

/// About the third axis, of vectors in a plane.
Eigen::Vector3d cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return {0.0, 0.0, a[0] * b[1] - a[1] * b[0]};
}
Eigen::Vector3d cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.cross(b); }
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

PartFrame::PartFrame(const fem::Part& part)
    : components_(fem::components(part.mesh.model)), mass_kg_(part.lumped_mass.sum()), mass_(part.lumped_mass) {
  if (part.mesh.model != fem::Model::plane_strain && part.mesh.model != fem::Model::solid)
    throw std::invalid_argument("only bodies in plane strain and solids turn");
  centre_m_.setZero();
  for (int node = 0; node < part.nodes(); ++node) centre_m_ += mass_[node] * part.mesh.position[fem::at(node)];
  centre_m_ /= mass_kg_;
  arm_.resize(part.dofs());
  inertia_.setZero();
  for (int node = 0; node < part.nodes(); ++node) {
    const Eigen::Vector3d arm = part.mesh.position[fem::at(node)] - centre_m_;
    for (int c = 0; c < components_; ++c) arm_[node * components_ + c] = arm[c];
    inertia_ += mass_[node] * arm * arm.transpose();
  }
}

template <int components>
PartFrame::Fit PartFrame::fit_of(const Eigen::VectorXd& u, Parallel* parallel) const {
  using Vector = Eigen::Matrix<double, components, 1>;
  using Matrix = Eigen::Matrix<double, components, components>;
  struct Sums {
    Vector moved = Vector::Zero();   ///< sum m u
    Matrix turned = Matrix::Zero();  ///< sum m u Y^T
  };
  const auto nodes = static_cast<int>(mass_.size());
  std::vector<Sums> blocks(static_cast<std::size_t>(blocks_of(nodes)));
  for_each_block(nodes, parallel, [&](int block, int first, int last) {
    Sums& sums = blocks[static_cast<std::size_t>(block)];
    for (int node = first; node < last; ++node) {
      const Vector moved = mass_[node] * at_node<components>(u, node);
      sums.moved += moved;
      sums.turned += moved * at_node<components>(arm_, node).transpose();
    }
  });
  Sums all;
  for (const Sums& block : blocks) {
    all.moved += block.moved;
    all.turned += block.turned;
  }
  const Matrix h = inertia_.topLeftCorner<components, components>() + all.turned;
  Fit fit;
  if (!all.turned.isZero(0.0)) fit.motion.rotation = rotation_of(h);  // else rounding would strain a body at rest
  fit.motion.from_m = fit.motion.to_m = centre_m_;
  fit.motion.to_m.head<components>() += all.moved / mass_kg_;
  fit.stretch.setZero();
  const Matrix stretch = fit.motion.rotation.topLeftCorner<components, components>().transpose() * h;
  fit.stretch.topLeftCorner<components, components>() = 0.5 * (stretch + stretch.transpose());
  return fit;
}

PartFrame::Fit PartFrame::fit(const Eigen::VectorXd& u, Parallel* parallel) const {
  return components_ == 2 ? fit_of<2>(u, parallel) : fit_of<3>(u, parallel);
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
  for_each_block(static_cast<int>(mass_.size()), parallel, [&](int, int first, int last) {
    for (int node = first; node < last; ++node)
      d.segment<components>(node * components) =
          change * at_node<components>(arm_, node) + back * (at_node<components>(u, node) - moved);
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

template <int components>
void PartFrame::force_of(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
                         Parallel* parallel) const {
  using Vector = Eigen::Matrix<double, components, 1>;
  using Matrix = Eigen::Matrix<double, components, components>;
  const auto nodes = static_cast<int>(mass_.size());
  std::vector<Eigen::Vector3d> blocks(static_cast<std::size_t>(blocks_of(nodes)));
  for_each_block(nodes, parallel, [&](int block, int first, int last) {
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (int node = first; node < last; ++node) {
      const Vector at = at_node<components>(arm_, node) + at_node<components>(d, node);
      moment += cross(at, at_node<components>(g, node));
    }
    blocks[static_cast<std::size_t>(block)] = moment;
  });
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& block : blocks) moment += block;
  Eigen::Matrix3d spread = fit.stretch.trace() * Eigen::Matrix3d::Identity() - fit.stretch;
  if (components == 2) spread.topLeftCorner<2, 2>().setIdentity();  // nothing turns about these axes
  const Eigen::Vector3d c = spread.inverse() * moment;
  const Matrix rotation = fit.motion.rotation.topLeftCorner<components, components>();
  p.resize(g.size());
  for_each_block(nodes, parallel, [&](int, int first, int last) {
    for (int node = first; node < last; ++node)
      p.segment<components>(node * components) =
          rotation * (at_node<components>(g, node) - mass_[node] * turned(c, at_node<components>(arm_, node)));
  });
}

void PartFrame::force(const Fit& fit, const Eigen::VectorXd& d, const Eigen::VectorXd& g, Eigen::VectorXd& p,
                      Parallel* parallel) const {
  components_ == 2 ? force_of<2>(fit, d, g, p, parallel) : force_of<3>(fit, d, g, p, parallel);
}

}  // namespace ricochet::solver
