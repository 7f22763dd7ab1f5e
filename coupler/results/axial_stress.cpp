#include "coupler/results/axial_stress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/write_file.hpp"

namespace ricochet::coupler {
namespace {

[[noreturn]] void refuse(const std::string& path, std::size_t line, std::string_view found) {
  throw ConfigError(fmt::format("{}:{}: found \"{}\", expected the axial stress that a participant tells", path, line,
                                found.substr(0, 80)));
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto end = line.find(separator);
    cells.push_back(line.substr(0, end));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

struct Layer {
  std::size_t body = 0;  ///< in the order of the bodies
  double low_m = 0.0;
  std::string name;    ///< of its column
  double share = 0.0;  ///< of its volume that has been told of
};

/// The layers of all participants, in the order of the columns.
class Layers {
 public:
  explicit Layers(const std::vector<std::string>& bodies) : bodies_(bodies) {}

  /// Takes a participant's column BODY/LOW/HIGH/SHARE in; false if it is none.
  bool add(std::string_view column) {
    const auto cells = split(column, '/');
    if (cells.size() != 4) return false;
    const auto body = std::find(bodies_.begin(), bodies_.end(), cells[0]);
    double low = 0.0, share = 0.0;
    const bool numbers = read(cells[1], low) && read(cells[3], share);
    if (body == bodies_.end() || !numbers) return false;
    const auto key = std::pair(static_cast<std::size_t>(body - bodies_.begin()), low);
    auto& layer = layers_[key];
    layer.name = column.substr(0, column.rfind('/'));
    layer.share += share;
    keys_.push_back(key);
    return true;
  }

  /// Per column in the order of `add`: which column of the sum it belongs to.
  [[nodiscard]] std::vector<std::size_t> targets() const {
    std::vector<std::size_t> result;
    for (const auto& key : keys_) {
      result.push_back(static_cast<std::size_t>(std::distance(layers_.begin(), layers_.find(key))));
    }
    return result;
  }
  [[nodiscard]] std::string header() const {
    std::string text = "time_s";
    for (const auto& [key, layer] : layers_) text += "," + layer.name;
    return text + "\n";
  }
  /// What the sum of a row starts from: 0, or nan where something is missing.
  [[nodiscard]] std::vector<double> first_sum() const {
    std::vector<double> sum;
    for (const auto& [key, layer] : layers_) {
      sum.push_back(std::abs(layer.share - 1.0) < 1e-6 ? 0.0 : std::numeric_limits<double>::quiet_NaN());
    }
    return sum;
  }

  static bool read(std::string_view cell, double& value) {
    const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    return error == std::errc() && stop == cell.data() + cell.size();
  }

 private:
  const std::vector<std::string>& bodies_;
  std::map<std::pair<std::size_t, double>, Layer> layers_;
  std::vector<std::pair<std::size_t, double>> keys_;
};

/// A participant's file, line by line.
struct Source {
  std::string path;
  std::ifstream file;
  std::size_t columns = 0, line = 1;

  /// The next line's time, as it is written, and numbers; false at the end and at a line that was never finished.
  bool next(std::string& time, std::vector<double>& values) {
    std::string text;
    if (!std::getline(file, text) || file.eof()) return false;
    ++line;
    const auto cells = split(text, ',');
    if (cells.size() != columns + 1) refuse(path, line, text);
    time = cells[0];
    for (std::size_t c = 1; c < cells.size(); ++c) {
      double value = 0.0;
      if (!Layers::read(cells[c], value)) refuse(path, line, cells[c]);
      values.push_back(value);
    }
    return true;
  }
};

std::vector<Source> open_sources(const ResultsDirectory& results, const std::vector<std::string>& participants,
                                 Layers& layers) {
  std::vector<Source> sources;
  for (const auto& participant : participants) {
    Source source{results.file("fields/" + participant + ".axial_stress"), {}, 0, 1};
    source.file.open(source.path);
    std::string header;
    if (!source.file || !std::getline(source.file, header)) continue;
    const auto columns = split(header, ',');
    if (columns[0] != "time_s") refuse(source.path, 1, header);
    source.columns = columns.size() - 1;
    for (std::size_t c = 1; c < columns.size(); ++c) {
      if (!layers.add(columns[c])) refuse(source.path, 1, columns[c]);
    }
    sources.push_back(std::move(source));
  }
  return sources;
}

}  // namespace

void add_up_axial_stress(const ResultsDirectory& results, const std::vector<std::string>& participants,
                         const std::vector<std::string>& bodies) {
  Layers layers(bodies);
  auto sources = open_sources(results, participants, layers);
  if (sources.empty()) return;
  const auto targets = layers.targets();
  const auto first_sum = layers.first_sum();
  std::string text = layers.header();
  for (;;) {
    std::string time, others_time;
    std::vector<double> values;
    bool told = true;
    for (auto& source : sources) {
      told = told && source.next(&source == &sources.front() ? time : others_time, values) &&
             (others_time.empty() || others_time == time);
    }
    if (!told) break;
    auto sum = first_sum;
    for (std::size_t c = 0; c < values.size(); ++c) sum[targets[c]] += values[c];
    text += time;
    for (const double stress : sum) fmt::format_to(std::back_inserter(text), ",{:.6g}", stress);
    text += '\n';
  }
  write_atomically(results.file("axial_stress.csv"), text);
  for (const auto& source : sources) std::filesystem::remove(source.path);
}

}  // namespace ricochet::coupler
