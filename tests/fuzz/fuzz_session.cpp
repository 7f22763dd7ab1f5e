// A participant's end of the conversation: a coupler with a key says whatever it likes. The first byte says what the
// participant is, messages follow.
#include "common/participant/session.hpp"
#include "common/wire/codec.hpp"
#include "tests/fuzz/conversation.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/small_participant.hpp"

namespace {

using namespace ricochet;

/// Sends `message` through the wire. Throws SolverError for numbers that the wire does not carry.
void pass(const wire::Message& message, wire::Message& received) {
  static msgpack::sbuffer buffer;
  wire::encode(message, buffer);
  wire::decode({buffer.data(), buffer.size()}, "the peer", received);
}

void converse(participant::Session& session, Archive& in, wire::Message& received) {
  wire::Message said, reply;
  session.hello(reply);
  for (std::int64_t n = 0; !session.over(); ++n) {
    fuzz::archive(in, said);
    said.sequence = n;
    said.run_id = "run";
    pass(said, received);
    if (session.handle(received, reply)) pass(reply, received);
    session.work_ahead();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  fuzz::SmallParticipant small(data[0]);
  participant::Session session(small);
  Archive in(fuzz::text_of(data + 1, size - 1), "the input");
  static wire::Message received;
  try {
    converse(session, in, received);
  } catch (const Error& error) {
    fuzz::tell(error);
    if (!session.over()) session.failure(error.code(), error.what(), received);
  }
  return 0;
}
