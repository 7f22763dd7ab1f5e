#include "common/wire/message.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ricochet::wire {
namespace {

void reset(std::string& value, const std::string&) { value.clear(); }
void reset(std::vector<std::string>& value, const std::vector<std::string>&) { value.clear(); }
void reset(Array& value, const Array&) { value.resize(0, 0); }
void reset(Bytes& value, const Bytes&) { value.data.clear(); }
template <class Number>
void reset(Number& value, Number initial) {
  value = initial;
}

}  // namespace

void Array::resize(int new_rows, int new_columns) {
  rows = new_rows;
  columns = new_columns;
  data.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
}

void Array::set(const std::vector<double>& values, int new_rows, int new_columns) {
  rows = new_rows;
  columns = new_columns;
  data.assign(values.begin(), values.end());
}

void Array::archive(Archive& a) {
  a(rows, columns, data);
  const bool fits =
      rows >= 0 && columns >= 0 && static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) == data.size();
  if (!fits) a.refuse("an array whose shape its numbers do not fill");
}

bool Description::has(Capability capability) const {
  return std::find(capabilities.begin(), capabilities.end(), name_of(capability)) != capabilities.end();
}

void Message::refuse(Kind wanted) const {
  throw std::logic_error("a message '" + std::string(name(kind)) + "' is read as '" + std::string(name(wanted)) + "'");
}

void clear_body(Message& message) {
  static const std::vector<Message> new_messages = [] {
    std::vector<Message> all(all_kinds().size());
    for (const Kind kind : all_kinds()) all[static_cast<std::size_t>(kind)].kind = kind;
    return all;
  }();
  const auto& fresh = new_messages[static_cast<std::size_t>(message.kind)];
  for (const auto& field : fields_of(message.kind)) {
    std::visit([&](auto* value) { reset(*value, *std::get<const std::decay_t<decltype(*value)>*>(field.of(fresh))); },
               field.in(message));
  }
}

double relative_difference(const std::vector<double>& accumulated, const std::vector<double>& absolute) {
  double difference = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < absolute.size(); ++i) {
    difference = std::max(difference, std::abs(accumulated[i] - absolute[i]));
    scale = std::max(scale, std::abs(absolute[i]));
  }
  return scale > 0.0 ? difference / scale : difference;
}

}  // namespace ricochet::wire
