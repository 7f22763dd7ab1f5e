#pragma once

#include <functional>

namespace ricochet::bench {

/// Computes one number in a child process of its own: with a fresh heap, and without adding to the memory of this
/// process, which the system counts as that of every command started later (the largest resident set survives exec).
/// Throws ParticipantError if the child does not finish; what went wrong stands on stderr.
double in_child(const std::function<double()>& compute);

}  // namespace ricochet::bench
