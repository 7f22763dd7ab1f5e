#include "coupler/results/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "common/base/error.hpp"
#include "common/problem/probes.hpp"

namespace ricochet::coupler {
namespace {

constexpr double share_rounding = 1e-6;  // shares are told with 9 digits

std::string place_of(const std::string& column) { return column.substr(0, column.find('.')); }

}  // namespace

Probes::Probes(const std::vector<History::Source>& sources, const scene::Scene& scene)
    : columns_(scene::probe_columns(scene)), share_(columns_.size(), 0.0), time_constant_s_(columns_.size(), 0.0) {
  for (const auto& gauge : scene.output.gauges) {
    for (std::size_t c = 0; c < columns_.size(); ++c)
      if (place_of(columns_[c]) == gauge.name) time_constant_s_[c] = gauge.rise_time_s / std::log(9.0);
  }
  for (const auto& source : sources) {
    streams_.emplace_back();
    if (source.columns.empty()) continue;
    if (source.columns.front() != "window")
      throw ProtocolError(
          fmt::format("participant '{}': the first probe column must be \"window\"", source.participant));
    for (std::size_t c = 1; c < source.columns.size(); ++c) add_column(source, source.columns[c]);
  }
}

void Probes::add_column(const History::Source& source, const std::string& column) {
  const auto slash = std::min(column.rfind('/'), column.size());
  const auto found = std::find(columns_.begin(), columns_.end(), column.substr(0, slash));
  double share = 0.0;
  const char *first = column.data() + std::min(slash + 1, column.size()), *end = column.data() + column.size();
  const auto [stop, error] = std::from_chars(first, end, share);
  if (found == columns_.end() || error != std::errc() || stop != end || !(share > -1.0 && share < 2.0))
    throw ProtocolError(
        fmt::format("participant '{}' announces the probe column \"{}\", expected COLUMN/SHARE of a "
                    "column of probes.csv",
                    source.participant, column));
  const auto place = static_cast<std::size_t>(found - columns_.begin());
  share_[place] += share;
  streams_.back().places.push_back(place);
}

std::vector<std::string> Probes::untold() const {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const auto name = place_of(columns_[c]);
    if (std::abs(share_[c] - 1.0) > share_rounding && (names.empty() || names.back() != name)) names.push_back(name);
  }
  return names;
}

void Probes::add(std::size_t participant, const std::vector<double>& values) {
  auto& stream = streams_[participant];
  stream.forget_used();
  stream.values.insert(stream.values.end(), values.begin(), values.end());
}

std::optional<ProbeRow> Probes::next(const WindowClock& clock) {
  const auto waits = [](const Stream& stream) { return !stream.places.empty() && stream.empty(); };
  const auto silent = [](const Stream& stream) { return stream.places.empty(); };
  if (std::any_of(streams_.begin(), streams_.end(), waits) || std::all_of(streams_.begin(), streams_.end(), silent))
    return std::nullopt;
  ProbeRow row;
  for (const double share : share_)
    row.values.push_back(std::abs(share - 1.0) <= share_rounding ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  for (auto& stream : streams_) {
    if (stream.places.empty()) continue;
    const double* told = &stream.values[stream.used];
    row.window = static_cast<std::int64_t>(told[0]);
    for (std::size_t c = 0; c < stream.places.size(); ++c) row.values[stream.places[c]] += told[c + 1];
    stream.used += stream.width();
  }
  row.time_s = clock.time_s(row.window);
  filter(row);
  return row;
}

void Probes::filter(ProbeRow& row) {
  const std::vector<double> input = row.values;
  for (std::size_t c = 0; c < columns_.size() && !output_.empty(); ++c) {
    const double tau = time_constant_s_[c], h = row.time_s - time_s_;
    if (tau <= 0.0) continue;
    const double lag = (input[c] - input_[c]) / h * tau;
    row.values[c] = input[c] - lag + (output_[c] - input_[c] + lag) * std::exp(-h / tau);
  }
  input_ = input;
  output_ = row.values;
  time_s_ = row.time_s;
}

void Probes::Stream::forget_used() {
  values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(used));
  used = 0;
}

void Probes::Stream::archive(Archive& a) {
  forget_used();
  a(values);
}

void Probes::archive(Archive& a) {
  const auto participants = streams_.size();
  a(streams_, input_, output_, time_s_);
  const bool other = streams_.size() != participants || input_.size() != output_.size() ||
                     !(output_.empty() || output_.size() == columns_.size());
  if (other) a.refuse("other probes");
  for (const auto& stream : streams_)
    if (stream.values.size() % stream.width() != 0) a.refuse("other probes");
}

}  // namespace ricochet::coupler
