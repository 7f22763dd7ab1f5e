#include "coupler/processes/process_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"
#include "coupler/processes/run_id.hpp"

namespace ricochet::coupler {
namespace {

std::vector<std::string> names_of(const std::vector<Member>& members) {
  std::vector<std::string> names;
  for (const auto& member : members) names.push_back(member.name);
  return names;
}

std::vector<ExpectedPeer> expected_peers(const std::vector<Member>& members) {
  std::vector<ExpectedPeer> expected;
  for (const auto& member : members) {
    expected.push_back({member.name, member.role, !member.by_hand() && !member.key_file.empty(), bool(member.inside)});
  }
  return expected;
}

/// Looks at what each says of itself, and whether they contradict each other.
void check_descriptions(const std::vector<PeerDescription>& descriptions) {
  std::string owner;
  for (const auto& description : descriptions) {
    const auto& name = description.participant;
    if (description.critical_time_step_s < 0.0) {
      throw ProtocolError(
          fmt::format("participant '{}' described 'critical_time_step_s' = {} s, allowed: 0 (none) or more", name,
                      description.critical_time_step_s));
    }
    if (!description.contact_owner) continue;
    if (!owner.empty()) {
      throw ProtocolError(
          fmt::format("participant '{}' described 'contact_owner' = true, and so did participant '{}': one of them "
                      "enforces the contact",
                      name, owner));
    }
    owner = name;
  }
}

}  // namespace

ProcessSet::ProcessSet(std::vector<Member> members, const RunIdentity& run, const std::string& endpoint)
    : members_(std::move(members)),
      timeout_s_(run.timeout_s),
      start_timeout_s_(run.start_wait_s()),
      listener_(std::in_place, endpoint, names_of(members_), run.largest_message),
      peers_(*listener_, launcher_, expected_peers(members_), run) {}

ProcessSet::~ProcessSet() { remove_keys(); }

/// Everything that a program is called with; the same wherever it is started.
std::vector<std::string> ProcessSet::arguments_of(const Member& member) const {
  const bool elsewhere = !member.key_file.empty();
  const std::string bound = listener_->endpoint();
  auto arguments = member.arguments;
  arguments.insert(arguments.end(), {"--connect", elsewhere ? remote_endpoint(bound) : local_endpoint(bound), "--key",
                                     elsewhere ? member.key_file : LaunchRequest::key_path});
  return arguments;
}

void ProcessSet::launch() {
  for (const auto& member : members_) {
    if (member.inside) continue;
    if (!member.key_file.empty()) write_key(member);
    if (!member.by_hand()) {
      launcher_.launch({member.name, member.executable, arguments_of(member), member.log_path,
                        member.key_file.empty() ? wire::to_text(listener_->key_of(member.name)) : ""});
      continue;
    }
    fmt::print(stderr, "participant '{}' is to be started by hand, within {} s:\n  {} {}\n", member.name,
               start_timeout_s_, member.executable, fmt::join(arguments_of(member), " "));
  }
}

void ProcessSet::write_key(const Member& member) const {
  std::error_code error;
  std::filesystem::create_directories(std::filesystem::path(member.key_file).parent_path(), error);
  write_atomically(member.key_file, wire::to_text(listener_->key_of(member.name)), 0600);
}

void ProcessSet::remove_keys() const {
  std::error_code ignored;
  for (const auto& member : members_) {
    if (member.key_file.empty()) continue;
    std::filesystem::remove(member.key_file, ignored);
    std::filesystem::remove(std::filesystem::path(member.key_file).parent_path(), ignored);  // only if it is empty
  }
}

void ProcessSet::meet() {
  for (std::size_t p = 0; p < members_.size(); ++p) enter(p);
  peers_.handshake();
  remove_keys();
}

/// While the processes start.
void ProcessSet::enter(std::size_t member) {
  if (!members_[member].inside) return;
  try {
    peers_.enter(member, members_[member].inside());
  } catch (const Error& error) {
    throw Error(error.code(),
                fmt::format("participant '{}' failed before it said hello: {}", members_[member].name, error.what()));
  }
}

std::vector<PeerDescription> ProcessSet::describe() {
  auto asked = peers_.all();
  for (const auto& peer : asked) {
    wire::Message request;
    request.make<wire::Describe>();
    peer.post(request);
  }
  std::vector<PeerDescription> descriptions;
  for (std::size_t p = 0; p < asked.size(); ++p) {
    const auto& said = asked[p].wait().as<wire::Description>();
    peers_.limit(p, said);
    descriptions.push_back({said, members_[p].name, members_[p].role});
  }
  check_descriptions(descriptions);
  return descriptions;
}

void ProcessSet::check_exit_codes() {
  const double patience_s = std::min(timeout_s_, 10.0);
  const bool ended = launcher_.wait_all(std::chrono::milliseconds(static_cast<long>(1000 * patience_s)));
  for (const auto& member : members_) {
    const auto end = launcher_.end_of(member.name);
    if (!launcher_.launched(member.name) || (end && end->signal == 0 && end->exit_status == 0)) continue;
    throw ParticipantError(fmt::format("participant '{}' finished its work but {}; see {}", member.name,
                                       ended && end ? end->text() : "did not end by itself",
                                       launcher_.log_path(member.name)));
  }
}

void ProcessSet::fail(int exit_code, const std::string& text, std::chrono::milliseconds grace) {
  peers_.announce_failure(exit_code, text, "coupler");
  if (grace.count() > 0) launcher_.wait_all(grace);
  launcher_.stop(std::chrono::milliseconds(2000));
}

}  // namespace ricochet::coupler
