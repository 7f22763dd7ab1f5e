#include "common/scene/protocols.hpp"

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace ricochet::scene {

const std::vector<ProtocolTraits>& protocols() {
  static const std::vector<ProtocolTraits> table{
      {"hughes_liu", Layout::hybrid, false, ""},
      {"kim", Layout::hybrid, false, ""},
      {"kim_predicted", Layout::hybrid, false,
       "protocol \"kim_predicted\" is unstable at almost any step: it is there to be studied, the energy watch will "
       "stop the run; use \"kim\" or \"hughes_liu\""},
      {"belytschko_mullen", Layout::hybrid, false, ""},
      {"prakash_hjelmstad", Layout::hybrid, true, ""},
      {"gravouil_combescure", Layout::hybrid, true,
       "protocol \"gravouil_combescure\" dissipates with substeps > 1 (71 % of a split oscillator's energy in ten "
       "periods): it is there to be studied; use \"prakash_hjelmstad\""},
      {"fixed_point", Layout::hybrid, false, ""},
      {"all_implicit", Layout::all_implicit, false, ""},
      {"all_explicit", Layout::all_explicit, false, ""},
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
  throw ConfigError("coupling.protocol: unknown protocol \"" + name + "\"" + did_you_mean(name, protocol_names()));
}

}  // namespace ricochet::scene
