#include "explicit_solver/stepping.hpp"

#include <utility>

namespace ricochet::explicit_solver {
namespace {

using Drive = std::variant<MotionDriven, ForceDriven>;

Drive drive_of(std::vector<solver::BodyState>& states, const participant::Setup& setup,
               std::optional<ExplicitContact> contact, const MakeForce& make_force) {
  if (setup.driven_by == participant::Drive::force)
    return Drive(std::in_place_type<ForceDriven>, states, setup, make_force);
  return Drive(std::in_place_type<MotionDriven>, states, std::move(contact), setup.clock, make_force);
}

}  // namespace

Stepping::Stepping(std::vector<solver::BodyState>& states, const participant::Setup& setup,
                   std::optional<ExplicitContact> contact, const MakeForce& make_force)
    : states_(states), drive_(drive_of(states, setup, std::move(contact), make_force)) {
  // A window needs the product with K only; K itself is a third of what a solver holds.
  for (auto& state : states_) state.part.stiffness = fem::SparseMatrix();
}

void Stepping::answer(participant::LinkOutput& output) const {
  std::visit([&](const auto& drive) { drive.answer(output); }, drive_);
}

void Stepping::synchronise(std::int64_t window, const std::vector<double>& link_input) {
  std::visit([&](auto& drive) { drive.synchronise(window, link_input); }, drive_);
}

void Stepping::reconfigure() {
  std::visit([](auto& drive) { drive.reconfigure(); }, drive_);
}

void Stepping::advance(std::int64_t window, const std::vector<double>& link_input) {
  std::visit([&](auto& drive) { drive.advance(window, link_input); }, drive_);
}

void Stepping::advance_substep(std::int64_t window, int substep, const std::vector<double>& link_input) {
  std::get<ForceDriven>(drive_).advance_substep(window, substep, link_input);
}

bool Stepping::accept(std::int64_t window) {
  return std::visit([&](auto& drive) { return drive.accept(window); }, drive_);
}

void Stepping::work_ahead(std::int64_t window) {
  std::visit([&](auto& drive) { drive.work_ahead(window); }, drive_);
}

void Stepping::freeze(participant::FrozenContact contact) {
  std::visit([&](auto& drive) { drive.freeze(contact); }, drive_);
}

Stepping::State Stepping::state() const {
  return {.bodies = solver::motions_of(states_),
          .drive = std::visit([](const auto& drive) -> decltype(State::drive) { return drive.state(); }, drive_)};
}

void Stepping::restore(const State& state) {
  solver::restore_motions(state.bodies, states_);
  if (auto* motion = std::get_if<MotionDriven>(&drive_)) {
    motion->restore(std::get<MotionDriven::State>(state.drive));
  } else {
    std::get<ForceDriven>(drive_).restore(std::get<ForceDriven::State>(state.drive));
  }
}

const Eigen::VectorXd& Stepping::internal(std::size_t part) const {
  return std::visit([&](const auto& drive) -> const Eigen::VectorXd& { return drive.internal(part); }, drive_);
}

solver::InternalForce& Stepping::force(std::size_t part) const {
  return std::visit([&](const auto& drive) -> solver::InternalForce& { return drive.force(part); }, drive_);
}

ExplicitContact* Stepping::contact() {
  return std::visit([](auto& drive) { return drive.contact(); }, drive_);
}

}  // namespace ricochet::explicit_solver
