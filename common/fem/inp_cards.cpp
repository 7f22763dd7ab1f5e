#include "common/fem/inp_cards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "common/base/error.hpp"

namespace ricochet::fem {
namespace {

constexpr const char* between_fields = " \t\r";

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(between_fields);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(between_fields) - first + 1);
}

/// Commas part fields; one at the end of the line starts none but says that the next line goes on.
InpLine fields_of(const std::string& text, int line) {
  InpLine result{line, {}, false};
  std::size_t begin = 0;
  for (std::size_t comma = text.find(','); comma != std::string::npos; comma = text.find(',', begin)) {
    result.fields.push_back(trimmed(text.substr(begin, comma - begin)));
    begin = comma + 1;
  }
  const std::string last = trimmed(text.substr(begin));
  result.goes_on = last.empty();
  if (!last.empty()) result.fields.push_back(last);
  return result;
}

void add_parameters(const InpLine& words, std::size_t first, InpCard& card) {
  for (std::size_t i = first; i < words.fields.size(); ++i) {
    const std::string& field = words.fields[i];
    const std::size_t equals = field.find('=');
    std::string value = equals == std::string::npos ? "" : trimmed(field.substr(equals + 1));
    if (value.size() > 1 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
    card.parameters.push_back({upper_case(trimmed(field.substr(0, equals))), value});
  }
}

InpCard card_of(const InpLine& words) {
  InpCard card;
  card.line = words.line;
  card.keyword = upper_case(words.fields.empty() ? "" : words.fields[0].substr(1));
  std::erase_if(card.keyword, [](char c) { return c == ' ' || c == '\t'; });
  add_parameters(words, 1, card);
  return card;
}

}  // namespace

std::string upper_case(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

const InpParameter* InpCard::find(const std::string& key) const {
  const auto found = std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.key == key; });
  return found == parameters.end() ? nullptr : &*found;
}

std::vector<InpCard> read_inp_cards(const std::string& path, const std::vector<std::string>& kept) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw ConfigError(fmt::format("cannot read mesh file {}", path));
  std::vector<InpCard> cards;
  bool keyword_goes_on = false, keep = false;
  int line = 0;
  for (std::string raw; std::getline(file, raw);) {
    ++line;
    const std::string text = trimmed(raw);
    if (text.empty() || text.starts_with("**")) continue;
    const bool keyword = text[0] == '*';
    if (!keyword && cards.empty())
      throw ConfigError(fmt::format("{}:{}: found \"{}\" before the first card; allowed: a line like *NODE", path, line,
                                    text.substr(0, 40)));
    if (!keyword && !keep && !keyword_goes_on) continue;
    InpLine words = fields_of(text, line);
    if (keyword) {
      cards.push_back(card_of(words));
      keep = std::find(kept.begin(), kept.end(), cards.back().keyword) != kept.end();
    } else if (keyword_goes_on) {
      add_parameters(words, 0, cards.back());
    } else {
      cards.back().data.push_back(std::move(words));
      continue;
    }
    keyword_goes_on = words.goes_on && text.back() == ',';
  }
  if (file.bad()) throw ConfigError(fmt::format("cannot read mesh file {}", path));
  return cards;
}

}  // namespace ricochet::fem
