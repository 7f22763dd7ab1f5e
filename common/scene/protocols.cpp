#include "common/scene/protocols.hpp"

#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace ricochet::scene {

const std::vector<ProtocolTraits>& protocols() {
  static const std::vector<ProtocolTraits> table{
      {"hughes_liu", Layout::hybrid, false, true, ""},
      {"kim", Layout::hybrid, false, true, ""},
      {"kim_predicted", Layout::hybrid, false, true,
       "protocol \"kim_predicted\" is unstable at almost any step: it is there to be studied, the energy watch will "
       "stop the run; use \"kim\" or \"hughes_liu\""},
      {"belytschko_mullen", Layout::hybrid, false, false, ""},
      {"prakash_hjelmstad", Layout::hybrid, true, false, ""},
      {"gravouil_combescure", Layout::hybrid, true, false,
       "protocol \"gravouil_combescure\" dissipates with substeps > 1 (71 % of a split oscillator's energy in ten "
       "periods): it is there to be studied; use \"prakash_hjelmstad\""},
      {"fixed_point", Layout::hybrid, false, false, ""},
      {"all_implicit", Layout::all_implicit, false, false, ""},
      {"all_explicit", Layout::all_explicit, false, false, ""},
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
