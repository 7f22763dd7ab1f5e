#pragma once

#include <string>

namespace ricochet::bench {

/// [[participant]] tables of a run of two participants that compute nothing and share `nodes` nodes of two components.
[[nodiscard]] std::string echo_participants(int nodes);

/// Two processes and one ZeroMQ ipc connection, nothing else: the time of one message each way [s], each as long as all
/// the messages that a window of `hughes_liu` with `echo_participants(nodes)` sends that way.
double ping_pong_s(int nodes, int exchanges);

}  // namespace ricochet::bench
