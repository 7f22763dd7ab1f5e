#include <fmt/format.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "coupler/protocols/belytschko_mullen.hpp"
#include "coupler/protocols/fixed_point.hpp"
#include "coupler/protocols/free_run.hpp"
#include "coupler/protocols/gravouil_combescure.hpp"
#include "coupler/protocols/hughes_liu.hpp"
#include "coupler/protocols/kim.hpp"
#include "coupler/protocols/kim_predicted.hpp"
#include "coupler/protocols/prakash_hjelmstad.hpp"

namespace ricochet::coupler {
namespace {

template <class P>
std::unique_ptr<Protocol> make(const ProtocolSettings& settings) {
  if constexpr (std::is_constructible_v<P, const ProtocolSettings&>) {
    return std::make_unique<P>(settings);
  } else {
    return std::make_unique<P>();
  }
}

}  // namespace

const std::vector<ProtocolEntry>& protocols() {
  static const std::vector<ProtocolEntry> list = {
      // name, explicit and implicit participants must be able to, coupled, known trouble
      {"hughes_liu", {}, {}, true, "", make<HughesLiu>},
      {"kim", {"repeat_window"}, {}, true, "", make<Kim>},
      {"kim_predicted",
       {},
       {},
       true,
       "is unstable at almost any time step; use hughes_liu or kim",
       make<KimPredicted>},
      {"belytschko_mullen", {"repeat_window"}, {"interface_stiffness"}, true, "", make<BelytschkoMullen>},
      {"prakash_hjelmstad",
       {"repeat_window", "driven_by_force"},
       {"interface_stiffness"},
       true,
       "",
       make<PrakashHjelmstad>},
      {"gravouil_combescure",
       {"repeat_window", "driven_by_force", "single_substep"},
       {"repeat_window", "interface_stiffness"},
       true,
       "",
       make<GravouilCombescure>},
      {"fixed_point", {"repeat_window"}, {"repeat_window"}, true, "", make<FixedPoint>},
      {"all_implicit", {}, {}, false, "", make<FreeRun>},
      {"all_explicit", {}, {}, false, "", make<FreeRun>},
  };
  return list;
}

const ProtocolEntry& find_protocol(const std::string& name) {
  std::vector<std::string> names;
  for (const auto& entry : protocols()) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  throw ConfigError(fmt::format("unknown coupling protocol \"{}\", allowed are {}{}", name, fmt::join(names, ", "),
                                did_you_mean(name, names)));
}

void require_capability(const wire::Message& description, const std::string& needed, const std::string& activity) {
  const auto& has = description.capabilities;
  if (std::find(has.begin(), has.end(), needed) != has.end()) return;
  throw ConfigError(fmt::format("participant '{}' ({}) cannot take part in {}: it lacks the capability \"{}\" (it has: "
                                "{}); choose another protocol or another solver",
                                description.participant, description.solver, activity, needed,
                                has.empty() ? "none" : fmt::format("{}", fmt::join(has, ", "))));
}

void check_capabilities(const ProtocolEntry& protocol, const std::vector<wire::Message>& descriptions) {
  int implicit = 0;
  for (const auto& description : descriptions) {
    const bool is_implicit = description.role == "implicit";
    implicit += is_implicit ? 1 : 0;
    for (const auto& needed : is_implicit ? protocol.implicit_capabilities : protocol.explicit_capabilities) {
      require_capability(description, needed, fmt::format("protocol {}", protocol.name));
    }
  }
  if (protocol.coupled && implicit != 1) {
    throw ConfigError(
        fmt::format("protocol {} needs exactly one implicit participant, the scene has {}", protocol.name, implicit));
  }
}

}  // namespace ricochet::coupler
