#include "common/scene/protocols.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace ricochet::scene {

const std::vector<ProtocolTraits>& protocols() {
  static const std::vector<ProtocolTraits> table{
      {.name = "hughes_liu", .may_switch = true},
      {.name = "kim",
       .may_switch = true,
       .exact_up_to_substeps = 0,
       .explicit_capabilities = {Capability::repeat_window}},
      {.name = "kim_predicted",
       .may_switch = true,
       .trouble = "is unstable at almost any time step; use hughes_liu or kim",
       .warning = "protocol \"kim_predicted\" is unstable at almost any step: it is there to be studied, the energy "
                  "watch will "
                  "stop the run; use \"kim\" or \"hughes_liu\""},
      {.name = "belytschko_mullen",
       .massless_boundary = true,
       .explicit_capabilities = {Capability::repeat_window},
       .implicit_capabilities = {Capability::interface_stiffness}},
      {.name = "prakash_hjelmstad",
       .dual = true,
       .own_substeps = true,
       .explicit_capabilities = {Capability::repeat_window, Capability::driven_by_force},
       .implicit_capabilities = {Capability::interface_stiffness}},
      {.name = "gravouil_combescure",
       .dual = true,
       .exact_up_to_substeps = 1,
       .explicit_capabilities = {Capability::repeat_window, Capability::driven_by_force, Capability::single_substep},
       .implicit_capabilities = {Capability::repeat_window, Capability::interface_stiffness},
       .warning =
           "protocol \"gravouil_combescure\" dissipates with substeps > 1 (71 % of a split oscillator's energy in ten "
           "periods): it is there to be studied; use \"prakash_hjelmstad\""},
      {.name = "fixed_point",
       .iterated = true,
       .massless_boundary = true,
       .explicit_capabilities = {Capability::repeat_window},
       .implicit_capabilities = {Capability::repeat_window}},
      {.name = "all_implicit", .layout = Layout::all_implicit},
      {.name = "all_explicit", .layout = Layout::all_explicit},
      {.name = "local_explicit", .layout = Layout::all_explicit, .local_steps = true},
  };
  return table;
}

std::vector<std::string> protocol_names() {
  std::vector<std::string> names;
  for (const ProtocolTraits& protocol : protocols()) names.push_back(protocol.name);
  return names;
}

const ProtocolTraits& protocol_traits(const std::string& name) {
  for (const ProtocolTraits& protocol : protocols())
    if (protocol.name == name) return protocol;
  throw ConfigError(fmt::format("coupling.protocol: unknown protocol \"{}\", allowed are {}{}", name,
                                fmt::join(protocol_names(), ", "), did_you_mean(name, protocol_names())));
}

}  // namespace ricochet::scene
