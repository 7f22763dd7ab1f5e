// stability.json: what `ricochet stability` keeps of a map, for pages that are made later.
#include <fmt/format.h>

#include <limits>

#include "common/base/error.hpp"
#include "common/base/vocabulary.hpp"
#include "coupler/report/parts/history_table.hpp"
#include "coupler/report/stability_page/stability_page.hpp"

namespace ricochet::report {
namespace {

double number_of(const Json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

void require(bool holds, const char* what) {
  if (!holds) throw ConfigError(what);
}

StabilityMap map_of(const Json& json) {
  StabilityMap map;
  map.title = json.at("title");
  map.step_title = json.at("step_title");
  map.against_title = json.at("against_title");
  map.against = json.at("against").get<std::vector<std::string>>();
  map.against_number = json.at("against_number").get<std::vector<double>>();
  map.logarithmic = json.at("logarithmic");
  map.notes = json.at("notes").get<std::vector<std::string>>();
  for (const auto& cell : json.at("cells")) {
    map.cells.push_back({cell.at("contact"), cell.at("column"), number_of(cell.at("step")),
                         number_of(cell.at("growth")), cell.at("stable")});
  }
  for (const auto& edge : json.at("edges")) {
    map.edges.push_back({edge.at("contact"), edge.at("column"), number_of(edge.at("step")), edge.at("kind")});
  }
  return map;
}

void check(const StabilityMap& map) {
  const auto known = [](const std::string& contact) { return find_named<FrozenContact>(contact).has_value(); };
  require(map.against_number.empty() || map.against_number.size() == map.against.size(),
          "'against_number' has another length than 'against'");
  for (const auto& cell : map.cells) {
    require(known(cell.contact), "'contact' is neither \"open\" nor \"sticking\"");
    require(cell.column < map.against.size(), "'column' is none of 'against'");
    require(cell.step > 0.0, "'step' is not above 0");
  }
  for (const auto& edge : map.edges) {
    require(known(edge.contact), "'contact' is neither \"open\" nor \"sticking\"");
    require(edge.column < map.against.size(), "'column' is none of 'against'");
    require(edge.kind == "predicted" || edge.kind == "measured", "'kind' is neither \"predicted\" nor \"measured\"");
  }
}

}  // namespace

std::string to_json(const StabilityMap& map) {
  Json cells = Json::array(), edges = Json::array();
  for (const auto& c : map.cells) {
    cells.push_back(
        {{"contact", c.contact}, {"column", c.column}, {"step", c.step}, {"growth", c.growth}, {"stable", c.stable}});
  }
  for (const auto& e : map.edges) {
    edges.push_back({{"contact", e.contact}, {"column", e.column}, {"step", e.step}, {"kind", e.kind}});
  }
  const Json json = {{"title", map.title},
                     {"step_title", map.step_title},
                     {"against_title", map.against_title},
                     {"against", map.against},
                     {"against_number", map.against_number},
                     {"logarithmic", map.logarithmic},
                     {"notes", map.notes},
                     {"cells", cells},
                     {"edges", edges}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

StabilityMap read_stability_map(const std::string& path) {
  const auto text = read_text(path);
  const auto refuse = [&](const char* why) {
    throw ConfigError(fmt::format("{} is not a map of ricochet stability: {}; run that again or remove it", path, why));
  };
  try {
    auto map = map_of(Json::parse(text));
    check(map);
    return map;
  } catch (const Json::exception& error) {
    refuse(error.what());
  } catch (const ConfigError& error) {
    refuse(error.what());
  }
  return {};
}

}  // namespace ricochet::report
