// Writes the seeds that are no plain text, with the writers of the program, into the folder of its argument: messages
// of the wire, a conversation, states of solvers.
#include <fstream>

#include "common/wire/codec.hpp"
#include "tests/fuzz/conversation.hpp"
#include "tests/fuzz/small_solvers.hpp"

namespace {

using namespace ricochet;
using wire::Kind;
using wire::Message;

void write(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

void fill(bool& value) { value = true; }
void fill(std::int64_t& value) { value = 3; }
void fill(double& value) { value = 0.25; }
void fill(std::string& value) { value = "text"; }
void fill(std::vector<std::string>& values) { values = {"one", "two"}; }
void fill(wire::Bytes& value) { value.data = "state"; }
void fill(wire::Array& array) {
  array.resize(2, 1);
  array.data = {0.5, -1.5};
}
void fill(Kind&) {}

/// A message of each kind with all its fields filled in.
void write_wire(const std::string& folder) {
  for (const Kind kind : wire::all_kinds()) {
    Message message;
    message.kind = kind;
    message.run_id = "run";
    for (const auto& field : wire::fields_of(kind)) std::visit([](auto* value) { fill(*value); }, field.in(message));
    msgpack::sbuffer buffer;
    wire::encode(message, buffer);
    write(folder + "/wire/" + std::string(wire::name(kind)), {buffer.data(), buffer.size()});
  }
}

/// Messages of a coupler from the welcome on, as tests/fuzz/fuzz_session.cpp reads them.
class Said {
 public:
  explicit Said(unsigned participant) : bytes_(1, static_cast<char>(participant)) {}
  template <class Body>
  Body& next(std::int64_t window = 0) {
    flush();
    message_.window = window;
    message_.substep = 0;
    under_way_ = true;
    return message_.make<Body>();
  }
  void substep(std::int64_t number) { message_.substep = number; }
  std::string take() {
    flush();
    return bytes_ + out_.take();
  }

 private:
  void flush() {
    if (under_way_) fuzz::archive(out_, message_);
  }
  std::string bytes_;
  Archive out_;
  Message message_;
  bool under_way_ = false;
};

void begin(Said& said, int nodes, int components, const std::string& driven_by, std::int64_t substeps) {
  auto& welcome = said.next<wire::Welcome>();
  welcome.participant = "small";
  welcome.timeout_s = 1.0;
  said.next<wire::Describe>();
  auto& initialize = said.next<wire::Initialize>();
  initialize.protocol = "hughes_liu";
  initialize.window_size_s = 0.01;
  initialize.driven_by = driven_by;
  initialize.substeps = substeps;
  initialize.interface_mass_kg.resize(nodes, 1);
  initialize.directions.resize(components, components);
  initialize.scene_position_m.resize(nodes, components);
  initialize.last_window = 50;
  initialize.fields_every = initialize.axial_stress_every = initialize.probes_every = 2;
  auto& synchronise = said.next<wire::Synchronise>();
  synchronise.integration = "explicit_central";
  synchronise.link_absolute.resize(nodes, components);
}

wire::Advance& advance(Said& said, std::int64_t window, int nodes, int components, bool at_once) {
  auto& advance = said.next<wire::Advance>(window);
  advance.link_increment.resize(nodes, components);
  advance.link_absolute.resize(0, components);
  advance.accept_at_once = at_once;
  advance.absolute_requested = advance.records_requested = true;
  return advance;
}

/// The state of a session of one node, as it archives it.
std::string saved_session() {
  Archive out, own;
  std::int64_t window = 2, fields_window = 2;
  std::vector<double> input = {0.0}, output = {0.0}, rows = {1.0, 0.5}, stress = {2.0, 0.5};
  double drift = 0.0, moved = 0.5, trial = 0.5;
  participant::ContactStatus contact;
  own(moved, trial);
  std::string participant = own.take();
  out(window, fields_window, input, output, drift, contact, rows, stress, participant);
  return out.take();
}

void write_sessions(const std::string& folder) {
  Said steps(1 | 1 << 4 | 1 << 5);
  begin(steps, 1, 1, "displacement", 1);
  advance(steps, 1, 1, 1, true);
  advance(steps, 2, 1, 1, false);
  steps.next<wire::Accept>(2).records_requested = true;
  steps.next<wire::SaveState>(2);
  steps.next<wire::RestoreState>(2).saved.data = saved_session();
  advance(steps, 3, 1, 1, true);
  steps.next<wire::Finish>(3);
  write(folder + "/session/steps", steps.take());

  Said forced(2 | 1 << 3);
  begin(forced, 2, 2, "force", 2);
  for (const std::int64_t substep : {1, 2}) {
    advance(forced, 1, 2, 2, true);
    forced.substep(substep);
  }
  forced.next<wire::Finish>(1);
  write(folder + "/session/substeps", forced.take());

  Said alone(0);
  begin(alone, 0, 1, "displacement", 1);
  advance(alone, 1, 0, 1, true).windows = 20;
  alone.next<wire::ReadState>(20);
  auto& load = alone.next<wire::LoadState>(20);
  load.state.resize(1, 1);
  load.frozen_contact = "open";
  write(folder + "/session/alone", alone.take());
}

}  // namespace

int main(int, char** argv) {
  const std::string folder = argv[1];
  write_wire(folder);
  write_sessions(folder);
  fuzz::SmallSolvers solvers;
  for (std::size_t i = 0; i < solvers.all().size(); ++i)
    write(folder + "/state/solver_" + std::to_string(i), static_cast<char>(i) + solvers.all()[i].state);
}
