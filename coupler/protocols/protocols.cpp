#include <map>
#include <stdexcept>

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

using Maker = std::unique_ptr<Protocol> (*)(const ProtocolSettings&);

const std::map<std::string, Maker>& makers() {
  static const std::map<std::string, Maker> makers = {
      {"hughes_liu", make<HughesLiu>},
      {"kim", make<Kim>},
      {"kim_predicted", make<KimPredicted>},
      {"belytschko_mullen", make<BelytschkoMullen>},
      {"prakash_hjelmstad", make<PrakashHjelmstad>},
      {"gravouil_combescure", make<GravouilCombescure>},
      {"fixed_point", make<FixedPoint>},
      {"all_implicit", make<FreeRun>},
      {"all_explicit", make<FreeRun>},
      {"local_explicit", make<FreeRun>},
  };
  return makers;
}

}  // namespace

std::unique_ptr<Protocol> make_protocol(const std::string& name, const ProtocolSettings& settings) {
  const auto found = makers().find(name);
  if (found == makers().end()) throw std::invalid_argument("protocol \"" + name + "\"");
  return found->second(settings);
}

std::vector<std::string> implemented_protocols() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : makers()) names.push_back(name);
  return names;
}

}  // namespace ricochet::coupler
