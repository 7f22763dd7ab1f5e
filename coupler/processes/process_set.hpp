#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/wire/channel.hpp"
#include "coupler/processes/launcher.hpp"
#include "coupler/processes/peers.hpp"

namespace ricochet::coupler {

/// A program of a set: which participant it is, and how it is started.
struct Member {
  std::string name;  ///< of the participant
  Role role = Role::explicit_solver;
  std::string executable;                ///< path of what is launched; of one that is started by hand, what to type
  std::vector<std::string> arguments{};  ///< its own; those that tell it where to connect are added
  std::string log_path{};                ///< takes what it prints; empty: it is started by hand
  /// Where it finds its key if it inherits no file of this process: it is started by hand, or by the program that is
  /// launched, perhaps on another machine.
  std::string key_file{};
  /// Makes it in this process; empty: it is a process of its own. See Inside.
  std::function<std::unique_ptr<participant::Participant>()> inside{};
  [[nodiscard]] bool by_hand() const { return log_path.empty() && !inside; }
};

/// The processes of a run, from the first start to the last exit code:
///
///   ProcessSet set(members, run, endpoint);
///   set.launch();
///   set.meet();
///   const auto descriptions = set.describe();
///   Coupling coupling(set.peers().all(), descriptions, clock);
///   ...
///   coupling.finish();
///   set.check_exit_codes();
///
/// Each member has a key of its own, by which the listener knows it; nobody without one is heard. A launched program
/// finds it in an open file, one that is started by hand or by another program in a file that only this user may read
/// and that is gone when everybody has come, or with this object. The reason of an early end is told to everyone by
/// `fail`; whoever still runs is ended with this object.
class ProcessSet {
 public:
  /// Listens at `endpoint` (wire::Listener), starts nothing.
  ProcessSet(std::vector<Member> members, const RunIdentity& run, const std::string& endpoint);
  ProcessSet(const ProcessSet&) = delete;
  ProcessSet& operator=(const ProcessSet&) = delete;
  ~ProcessSet();

  /// Starts the members, or prints what to type for those that are started by hand. Throws ParticipantError naming the
  /// program that cannot be started; MachineError or ConfigError if a key or a log cannot be written.
  void launch();
  /// Waits until everybody has said hello: Peers::handshake.
  void meet();
  /// Every participant's word on itself, in the order of the members, with `participant` and `role` filled in; from
  /// here on nobody may send more than follows from it. ProtocolError if what they say cannot be.
  [[nodiscard]] std::vector<PeerDescription> describe();
  /// Waits until the launched processes have ended; ParticipantError naming the first that does not, or not with exit
  /// code 0.
  void check_exit_codes();
  /// Tells everyone that the run is over, and why, and ends who does not end by itself within `grace`.
  void fail(int exit_code, const std::string& text, std::chrono::milliseconds grace = {});
  /// Closes every connection as if this process were gone, but ends nobody. Afterwards only `launcher` is of use.
  void hang_up() { listener_.reset(); }

  [[nodiscard]] Peers& peers() { return peers_; }
  [[nodiscard]] wire::Listener& listener() { return *listener_; }
  [[nodiscard]] Launcher& launcher() { return launcher_; }

 private:
  [[nodiscard]] std::vector<std::string> arguments_of(const Member& member) const;
  void enter(std::size_t member);
  void write_key(const Member& member) const;
  void remove_keys() const;

  std::vector<Member> members_;
  double timeout_s_, start_timeout_s_;
  Launcher launcher_;
  std::optional<wire::Listener> listener_;
  Peers peers_;
};

}  // namespace ricochet::coupler
