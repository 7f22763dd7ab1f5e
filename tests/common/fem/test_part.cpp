#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/common/fem/sample_elements.hpp"
#include "tests/common/fem/test_help.hpp"

namespace ricochet::fem {
namespace {

using sample::steel;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class PartOf : public testing::TestWithParam<Model> {
 protected:
  const Model model_ = GetParam();
  const Section section_ = sample::section(model_);
  const Mesh mesh_ = sample::distorted_mesh(model_);
  const int components_ = components(model_);
};

INSTANTIATE_TEST_SUITE_P(Models, PartOf, testing::ValuesIn(sample::every_model),
                         [](const auto& tested) { return sample::name(tested.param); });

/// Adds a part's values per dof into a vector of the whole body.
void scatter(const Part& part, const Eigen::VectorXd& values, int per_node, Eigen::VectorXd& whole) {
  for (int i = 0; i < part.nodes(); ++i) {
    const int node = part.body_node[static_cast<std::size_t>(i)];
    whole.segment(node * per_node, per_node) += values.segment(i * per_node, per_node);
  }
}

TEST_P(PartOf, TwoPartsAddUpToTheWhole) {
  const Part whole = sample::whole_part(mesh_, section_);
  const std::vector<int> all = sample::all_elements(mesh_);
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(whole.nodes()), force = Eigen::VectorXd::Zero(whole.dofs());
  Eigen::VectorXd load = Eigen::VectorXd::Zero(whole.dofs()), gravity = Eigen::VectorXd::Zero(whole.dofs());
  Eigen::VectorXd u(whole.dofs());
  for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = 1e-5 * std::sin(1.7 * static_cast<double>(i));
  for (const auto& elements : {std::vector<int>(all.begin(), middle), std::vector<int>(middle, all.end())}) {
    const Part part = extract_part(mesh_, "body", section_, steel, elements);
    Eigen::VectorXd local(part.dofs());
    for (int i = 0; i < part.dofs(); ++i) {
      local[i] = u[part.body_node[static_cast<std::size_t>(i / components_)] * components_ + i % components_];
    }
    scatter(part, part.lumped_mass, 1, mass);
    scatter(part, part.stiffness * local, components_, force);
    for (const auto& [surface, edges] : mesh_.surfaces) {
      scatter(part, traction_force(part, surface, {1e6, 2e6, 4e6}), components_, load);
    }
    scatter(part, gravity_force(part, {1.0, -9.81, 3.0}), components_, gravity);
  }
  Eigen::VectorXd whole_load = Eigen::VectorXd::Zero(whole.dofs());
  for (const auto& [surface, edges] : mesh_.surfaces) whole_load += traction_force(whole, surface, {1e6, 2e6, 4e6});
  EXPECT_LT(sample::relative_error(mass, whole.lumped_mass), 1e-14);
  EXPECT_LT(sample::relative_error(force, whole.stiffness * u), 1e-12);
  EXPECT_LT(sample::relative_error(load, whole_load), 1e-14);
  EXPECT_LT(sample::relative_error(gravity, gravity_force(whole, {1.0, -9.81, 3.0})), 1e-14);
}

TEST_P(PartOf, StiffnessIsSymmetricToTheLastBitInStructureAndValue) {
  const SparseMatrix stiffness = sample::whole_part(mesh_, section_).stiffness;
  const SparseMatrix transposed = stiffness.transpose();
  ASSERT_EQ(stiffness.nonZeros(), transposed.nonZeros());
  for (Eigen::Index i = 0; i < stiffness.nonZeros(); ++i) {
    EXPECT_EQ(stiffness.innerIndexPtr()[i], transposed.innerIndexPtr()[i]);
    EXPECT_EQ(stiffness.valuePtr()[i], transposed.valuePtr()[i]);
  }
}

TEST_P(PartOf, TheSameElementsGiveTheSameBits) {
  const Part one = extract_part(mesh_, "body", section_, steel, {1, 2, 3});
  const Part shuffled = extract_part(mesh_, "body", section_, steel, {3, 1, 2});
  EXPECT_EQ(one.body_element, shuffled.body_element);
  EXPECT_EQ(one.lumped_mass, shuffled.lumped_mass);
  EXPECT_EQ(Eigen::MatrixXd(one.stiffness), Eigen::MatrixXd(shuffled.stiffness));

  const Part with_extra = extract_part(mesh_, "body", section_, steel, {1, 2, 3}, {0, one.body_node.back()});
  ASSERT_EQ(with_extra.nodes(), one.nodes() + 1);
  EXPECT_EQ(with_extra.body_node.front(), 0);
  EXPECT_EQ(with_extra.lumped_mass[0], 0.0);
  EXPECT_EQ(Eigen::VectorXd(with_extra.lumped_mass.tail(one.nodes())), one.lumped_mass);
  const Eigen::MatrixXd stiffness = with_extra.stiffness;
  EXPECT_EQ(stiffness.topRows(components_).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(Eigen::MatrixXd(stiffness.bottomRightCorner(one.dofs(), one.dofs())), Eigen::MatrixXd(one.stiffness));
}

TEST_P(PartOf, GravityAddsUpToTheWeight) {
  const Part part = sample::whole_part(mesh_, section_);
  const Eigen::VectorXd force = gravity_force(part, {2.0, -9.81, 5.0});
  const double mass = part.lumped_mass.sum();
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (int i = 0; i < part.dofs(); ++i) total[i % components_] += force[i];
  EXPECT_NEAR(total[0], 2.0 * mass, 1e-12 * mass);
  EXPECT_NEAR(total[1], components_ == 1 ? 0.0 : -9.81 * mass, 1e-12 * mass);
  EXPECT_NEAR(total[2], components_ == 3 ? 5.0 * mass : 0.0, 1e-12 * mass);
}

TEST_P(PartOf, TractionAddsUpToTractionTimesArea) {
  const Part part = sample::whole_part(mesh_, section_);
  double area = section_.measure;
  if (model_ == Model::plane_strain) area *= 0.03;
  if (model_ == Model::axisymmetric) area = std::numbers::pi * 0.03 * 0.03;
  if (model_ == Model::solid) area = 0.03 * 0.02;
  const Eigen::VectorXd force = traction_force(part, "end", {3e6, -5e6, 7e6});
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (int i = 0; i < part.dofs(); ++i) total[i % components_] += force[i];
  EXPECT_NEAR(total[0], 3e6 * area, 1e-9);
  EXPECT_NEAR(total[1], components_ == 1 ? 0.0 : -5e6 * area, 1e-9);
  EXPECT_NEAR(total[2], components_ == 3 ? 7e6 * area : 0.0, 1e-9);
}

TEST_P(PartOf, ElementBoundOfTheTimeStepIsSafe) {
  const Part part = sample::whole_part(mesh_, section_);
  const std::vector<bool> free(static_cast<std::size_t>(part.dofs()), false);
  const double assembled = 2.0 / std::sqrt(max_frequency_squared(part.stiffness, part.lumped_mass, components_, free));
  EXPECT_LE(element_critical_time_step(part), assembled);
  EXPECT_GT(element_critical_time_step(part), 0.4 * assembled);
}

TEST(Part, CriticalStepOfABarIsElementLengthOverWaveSpeed) {
  const Section section = sample::section(Model::bar);
  const Part part = sample::whole_part(bar_mesh(graded_coordinates(0.0, 1.0, 50, 1.0)), section);
  const double exact = 0.02 / longitudinal_wave_speed(Model::bar, steel);
  EXPECT_NEAR(element_critical_time_step(part), exact, 1e-12 * exact);
  const std::vector<bool> free(51, false);
  EXPECT_NEAR(2.0 / std::sqrt(max_frequency_squared(part.stiffness, part.lumped_mass, 1, free)), exact, 1e-9 * exact);
}

TEST(Part, WithoutElementsHasNoCriticalStepAndOnlyItsExtraNodes) {
  const Mesh mesh = bar_mesh({0.0, 1.0, 2.0});
  const Part part = extract_part(mesh, "rod", sample::section(Model::bar), steel, {}, {2});
  EXPECT_EQ(element_critical_time_step(part), std::numeric_limits<double>::infinity());
  EXPECT_THAT(part.body_node, ElementsAre(2));
  EXPECT_EQ(part.lumped_mass[0], 0.0);
  EXPECT_EQ(part.stiffness.nonZeros(), 0);
}

TEST(Part, RestrictsSurfacesAndGroupsToItsOwnElements) {
  Mesh mesh = quadrilateral_mesh(Model::plane_strain, {0.0, 1.0, 2.0}, {0.0, 1.0, 2.0});
  mesh.element_groups["diagonal"] = {0, 3};
  mesh.element_groups["top"] = {2, 3};
  const Part part = extract_part(mesh, "body", {Model::plane_strain, 1.0}, steel, {1, 3});
  EXPECT_THAT(part.body_node, ElementsAre(1, 2, 4, 5, 7, 8));
  EXPECT_EQ(part.mesh.elements[1], (Element{ElementKind::quadrilateral, {2, 3, 5, 4}}));
  EXPECT_THAT(part.mesh.element_groups.at("diagonal"), ElementsAre(1));
  EXPECT_THAT(part.mesh.surfaces.at("start"), ElementsAre(Face{0, 1}));
  EXPECT_THAT(part.mesh.surfaces.at("outer"), ElementsAre(Face{1, 3}, Face{3, 5}));
  EXPECT_THAT(part.mesh.surfaces.at("inner"), IsEmpty()) << "its name stays known";
  EXPECT_EQ(traction_force(part, "inner", {1.0, 1.0}), Eigen::VectorXd::Zero(12));
}

TEST(Part, TakesNoLoadOfANodeWhoseElementIsElsewhere) {
  const Mesh mesh = bar_mesh({0.0, 1.0, 2.0});
  const Part part = extract_part(mesh, "rod", sample::section(Model::bar), steel, {0}, {2});
  EXPECT_EQ(part.nodes(), 3);
  EXPECT_THAT(part.mesh.surfaces.at("start"), ElementsAre(Face{0}));
  EXPECT_THAT(part.mesh.surfaces.at("end"), IsEmpty());
}

TEST(Part, RefusesTractionOnAnUnknownSurface) {
  const Part part = sample::distorted_part(Model::plane_strain);
  EXPECT_THAT(sample::message_of([&] {
                (void)traction_force(part, "stat", {1.0, 0.0});
              }),
              HasSubstr("did you mean \"start\"?"));
}

}  // namespace
}  // namespace ricochet::fem
