#pragma once

#include <string>

#include "common/scene/scene.hpp"

namespace ricochet::coupler {

/// Name of one run, unlike that of any other on this machine: UTC time, process id, random hexadecimal digits.
[[nodiscard]] std::string make_run_id();

/// Where the coupler listens: with transport "tcp" "tcp://address:port", port "*" where the scene leaves it free; else
/// "ipc://*", a socket in a folder that only this user may enter.
[[nodiscard]] std::string listen_endpoint(const scene::CouplingSettings& coupling);

/// The address for participants on this machine, given what the listener is bound to: "any address" becomes loopback.
[[nodiscard]] std::string local_endpoint(const std::string& bound);

/// The address that a participant on another machine would connect to: "any address" becomes this machine's name.
[[nodiscard]] std::string remote_endpoint(const std::string& bound);

}  // namespace ricochet::coupler
