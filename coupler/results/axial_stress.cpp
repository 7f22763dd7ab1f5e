#include "coupler/results/axial_stress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto end = line.find(separator);
    cells.push_back(line.substr(0, end));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
  }
}

bool read(std::string_view cell, double& value) {
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && stop == cell.data() + cell.size();
}

}  // namespace

AxialStress::AxialStress(const std::vector<History::Source>& sources, const std::vector<std::string>& bodies) {
  for (const auto& source : sources) {
    streams_.emplace_back();
    if (source.columns.empty()) continue;
    if (source.columns.front() != "window") {
      throw ProtocolError(
          fmt::format("participant '{}': the first axial stress column must be \"window\"", source.participant));
    }
    for (std::size_t c = 1; c < source.columns.size(); ++c) add_column(source, source.columns[c], bodies);
  }
}

void AxialStress::add_column(const History::Source& source, const std::string& column,
                             const std::vector<std::string>& bodies) {
  const auto cells = split(column, '/');
  const auto body = std::find(bodies.begin(), bodies.end(), cells[0]);
  double low = 0.0, high = 0.0, share = 0.0;
  const bool layer =
      cells.size() == 4 && body != bodies.end() && read(cells[1], low) && read(cells[2], high) && read(cells[3], share);
  if (!layer) {
    throw ProtocolError(
        fmt::format("participant '{}' announces the axial stress column \"{}\", expected BODY/LOW/HIGH/SHARE (bodies: "
                    "{})",
                    source.participant, column, fmt::join(bodies, ", ")));
  }
  const Place place(static_cast<std::size_t>(body - bodies.begin()), low);
  layers_[place].name = column.substr(0, column.rfind('/'));
  layers_[place].share += share;
  streams_.back().places.push_back(place);
}

void AxialStress::add(std::size_t participant, const std::vector<double>& values) {
  auto& told = streams_[participant].values;
  told.insert(told.end(), values.begin(), values.end());
}

void AxialStress::archive(Archive& a) {
  const auto participants = streams_.size();
  a(streams_);
  if (streams_.size() != participants) a.refuse("other participants");
}

/// Rows that all who tell any have told.
std::size_t AxialStress::rows() const {
  std::size_t rows = std::numeric_limits<std::size_t>::max();
  for (const auto& stream : streams_) {
    if (!stream.places.empty()) rows = std::min(rows, stream.values.size() / stream.width());
  }
  return told() ? rows : 0;
}

std::string AxialStress::csv(const WindowClock& clock) const {
  std::string text = "time_s";
  std::map<Place, std::size_t> position;
  std::vector<double> nothing;
  for (const auto& [place, layer] : layers_) {
    text += "," + layer.name;
    position[place] = nothing.size();
    nothing.push_back(std::abs(layer.share - 1.0) < 1e-6 ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  }
  text += '\n';
  auto out = std::back_inserter(text);
  for (std::size_t row = 0, last = rows(); row < last; ++row) {
    std::vector<double> sum = nothing;
    double window = 0.0;
    for (const auto& stream : streams_) {
      if (stream.places.empty()) continue;
      const double* values = stream.values.data() + row * stream.width();
      window = values[0];
      for (std::size_t c = 0; c < stream.places.size(); ++c) sum[position.at(stream.places[c])] += values[c + 1];
    }
    out = fmt::format_to(out, "{:.17g}", clock.time_s(static_cast<std::int64_t>(window)));
    for (const double stress : sum) out = fmt::format_to(out, ",{:.6g}", stress);
    text += '\n';
  }
  return text;
}

}  // namespace ricochet::coupler
