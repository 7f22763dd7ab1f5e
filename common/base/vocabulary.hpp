#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Words that scene files, messages and result files share: each kind of them an enum with one table of its names, by
/// which they are read, written, listed in error texts and suggested.
namespace ricochet {

/// The role of a participant.
enum class Role { explicit_solver, implicit_solver };
/// How a participant finds accelerations: beta = 1/4 | beta = 0.
enum class Integration { implicit_newmark, explicit_central };
/// The kind of a participant's link input.
enum class Drive { displacement, force };
/// The contact while the stability of the coupled scheme is measured: no force, or every pair held together
/// (normally and, with friction, tangentially; in tension, too) at zero gap.
enum class FrozenContact { open, sticking };
/// The carrier of messages; `automatic`: shared memory where it can be had, else ZeroMQ.
enum class Transport { automatic, shm, zmq, tcp };

/// Abilities that a participant may have besides those that everyone must have.
enum class Capability {
  repeat_window,        ///< may be asked to advance the same window again before accept
  switch_integration,   ///< implicit: knows both integrations
  driven_by_force,      ///< explicit: integrates its interface nodes, given the interface multiplier
  single_substep,       ///< can advance one substep of a window
  interface_stiffness,  ///< implicit: takes a stiffness into its operator that acts on the interface nodes
  load_state,           ///< can load and tell its motion
  reconfigure,          ///< can go on with windows of another size
  save_state,           ///< can save all that it goes on from, and be restored to it
};

/// How a run stands, or ended.
enum class RunStatus {
  running,
  done,
  interrupted,
  scene_wrong,
  unstable,
  participant_failed,
  protocol_broken,
  left_model,
  machine_failed,
};

template <class E>
struct Named {
  E value;
  std::string_view name;
};

/// The table of an enum's names, in the order in which they are listed.
template <class E>
struct NamesOf;

template <>
struct NamesOf<Role> {
  static constexpr std::array<Named<Role>, 2> table{
      {{Role::explicit_solver, "explicit"}, {Role::implicit_solver, "implicit"}}};
};

template <>
struct NamesOf<Integration> {
  static constexpr std::array<Named<Integration>, 2> table{
      {{Integration::implicit_newmark, "implicit_newmark"}, {Integration::explicit_central, "explicit_central"}}};
};

template <>
struct NamesOf<Drive> {
  static constexpr std::array<Named<Drive>, 2> table{{{Drive::displacement, "displacement"}, {Drive::force, "force"}}};
};

template <>
struct NamesOf<FrozenContact> {
  static constexpr std::array<Named<FrozenContact>, 2> table{
      {{FrozenContact::open, "open"}, {FrozenContact::sticking, "sticking"}}};
};

template <>
struct NamesOf<Transport> {
  static constexpr std::array<Named<Transport>, 4> table{
      {{Transport::automatic, "auto"}, {Transport::shm, "shm"}, {Transport::zmq, "zmq"}, {Transport::tcp, "tcp"}}};
};

template <>
struct NamesOf<Capability> {
  static constexpr std::array<Named<Capability>, 8> table{{{Capability::repeat_window, "repeat_window"},
                                                           {Capability::switch_integration, "switch_integration"},
                                                           {Capability::driven_by_force, "driven_by_force"},
                                                           {Capability::single_substep, "single_substep"},
                                                           {Capability::interface_stiffness, "interface_stiffness"},
                                                           {Capability::load_state, "load_state"},
                                                           {Capability::reconfigure, "reconfigure"},
                                                           {Capability::save_state, "save_state"}}};
};

template <>
struct NamesOf<RunStatus> {
  static constexpr std::array<Named<RunStatus>, 9> table{{{RunStatus::running, "running"},
                                                          {RunStatus::done, "done"},
                                                          {RunStatus::interrupted, "interrupted"},
                                                          {RunStatus::scene_wrong, "scene_wrong"},
                                                          {RunStatus::unstable, "unstable"},
                                                          {RunStatus::participant_failed, "participant_failed"},
                                                          {RunStatus::protocol_broken, "protocol_broken"},
                                                          {RunStatus::left_model, "left_model"},
                                                          {RunStatus::machine_failed, "machine_failed"}}};
};

/// Empty for a value that is none of the enum's.
template <class E>
[[nodiscard]] constexpr std::string_view name_of(E value) {
  for (const auto& entry : NamesOf<E>::table) {
    if (entry.value == value) return entry.name;
  }
  return "";
}

/// The value of that name; nothing if there is none.
template <class E>
[[nodiscard]] constexpr std::optional<E> find_named(std::string_view name) {
  for (const auto& entry : NamesOf<E>::table) {
    if (entry.name == name) return entry.value;
  }
  return std::nullopt;
}

template <class E>
[[nodiscard]] std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const auto& entry : NamesOf<E>::table) names.emplace_back(entry.name);
  return names;
}

}  // namespace ricochet
