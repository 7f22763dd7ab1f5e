#pragma once

#include <string>
#include <vector>

#include "common/base/archive.hpp"
#include "common/check/check.hpp"
#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Tells a participant's program from another one, as far as this end can see: by all that it describes, and of a
/// program of somebody else's also the digest of its file and what it answers at the start of a run to a change of its
/// link input that is tried. A checkpoint keeps it, so that a run goes on with the programs that it began with.
struct Program {
  /// A text, or numbers.
  struct Fact {
    std::string what, text;
    std::vector<double> numbers{};
    void archive(Archive& a) { a(what, text, numbers); }
  };
  std::string participant;
  std::vector<Fact> facts;
  void archive(Archive& a) { a(participant, facts); }
};

/// For participants that are synchronised at the start of a run, and left so. `executables`: paths, empty where none is
/// launched.
[[nodiscard]] std::vector<Program> programs_of(const scene::Problem& problem,
                                               const std::vector<PeerDescription>& descriptions,
                                               const std::vector<std::string>& executables, std::vector<Link>& links);

/// Throws ConfigError that names the first participant and fact that differs: numbers by more than 1e-7 of the largest,
/// which rounding in other orders does not reach.
void require_same(const std::vector<Program>& began, const std::vector<Program>& now);

}  // namespace ricochet::coupler
