#include "coupler/watch/outside_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

struct Kind {
  const char* name;
  bool wrong;
};
/// In the order of the wire's numbers, from 1.
constexpr std::array<Kind, 6> kinds = {{{"strain", false},
                                        {"rotation", false},
                                        {"slip", false},
                                        {"inverted_element", true},
                                        {"off_partner", true},
                                        {"penetration", true}}};

std::string place(const Departed& d) {
  return fmt::format("in body '{}' at ({:.6g}, {:.6g}) m, t = {:.6g} s", d.body, d.x_m, d.y_m, d.time_s);
}

std::string text_of(const Departed& d) {
  if (d.kind == "strain") {
    return fmt::format(
        "strain of {:.3g} % {}: strain is small no more, expect errors of stresses and forces of "
        "about {:.2g} %",
        100 * d.size, place(d), 100 * d.size);
  }
  if (d.kind == "rotation") {
    return fmt::format(
        "rotation of {:.3g} degrees {}: small strain sees in it a strain of {:.2g} that is not "
        "there, and the stress of that",
        d.size * 180.0 / std::numbers::pi, place(d), 0.5 * d.size * d.size);
  }
  if (d.kind == "slip") {
    return fmt::format(
        "nodes in contact {} are {:.3g} element edges from being opposite: pressure and friction act "
        "that far from their place",
        place(d), d.size);
  }
  if (d.kind == "inverted_element") return fmt::format("an element {} is turned inside out", place(d));
  if (d.kind == "off_partner") {
    return fmt::format(
        "a node in contact {} has slid {:.3g} element edges past the end of its partner's surface, "
        "and is still pressed",
        place(d), d.size);
  }
  return fmt::format(
      "a contact node {} lies {:.3g} of an element's depth within the other body: the penalty is too "
      "soft for this impact, or "
      "the step too long",
      place(d), d.size);
}

}  // namespace

std::vector<std::string> OutsideModel::update(const std::vector<Link>& links, std::int64_t window) {
  std::vector<std::string> news;
  for (const auto& link : links) take(link, news);
  for (auto& overlap : overlaps_.update(links, window)) {
    add({.kind = "overlap",
         .body = overlap.body,
         .size = overlap.depth_m,
         .first_s = overlap.time_s,
         .time_s = overlap.time_s,
         .within_s = overlap.within_s,
         .x_m = overlap.place[0],
         .y_m = overlap.place[1],
         .looks = 1,
         .wrong = true,
         .text = fmt::format("bodies '{}' and '{}' overlap by {:.3g} m at ({:.6g}, {:.6g}) m, t = {:.6g} s, with no "
                             "contact between them",
                             overlap.body, overlap.other, overlap.depth_m, overlap.place[0], overlap.place[1],
                             overlap.time_s)},
        news);
  }
  return news;
}

void OutsideModel::take(const Link& link, std::vector<std::string>& news) {
  const auto& told = link.departures();
  for (int row = 0; row < told.rows; ++row) {
    const double* v = &told.data[static_cast<std::size_t>(row * wire::departure_columns)];
    const Kind& kind = kinds[static_cast<std::size_t>(v[0]) - 1];
    Departed departed{.kind = kind.name,
                      .body = link.description().bodies[static_cast<std::size_t>(v[1])],
                      .size = v[5],
                      .first_s = v[3] * problem_.window_size_s,
                      .time_s = v[6] * problem_.window_size_s,
                      .within_s = v[2] * problem_.window_size_s,
                      .x_m = v[7],
                      .y_m = v[8],
                      .looks = static_cast<std::int64_t>(v[4]),
                      .wrong = kind.wrong,
                      .text = {}};
    departed.text = text_of(departed);
    add(std::move(departed), news);
  }
}

/// Several participants may have elements of a body: the largest counts.
void OutsideModel::add(Departed departed, std::vector<std::string>& news) {
  const auto known = std::find_if(found_.begin(), found_.end(), [&](const Departed& d) {
    return d.kind == departed.kind && d.body == departed.body;
  });
  if (known == found_.end()) {
    news.push_back(departed.text);
    found_.push_back(std::move(departed));
    return;
  }
  departed.first_s = std::min(departed.first_s, known->first_s);
  departed.within_s = std::min(departed.within_s, known->within_s);
  departed.looks = std::max(departed.looks, known->looks);
  if (departed.size < known->size) {
    departed.size = known->size;
    departed.time_s = known->time_s;
    departed.x_m = known->x_m;
    departed.y_m = known->y_m;
    departed.text = known->text;
  }
  *known = std::move(departed);
}

std::optional<double> OutsideModel::valid_until_s() const {
  std::optional<double> until;
  for (const auto& d : found_) {
    if (d.wrong) until = std::min(until.value_or(d.within_s), d.within_s);
  }
  return until;
}

void OutsideModel::stop_if_wrong() const {
  const auto first = std::find_if(found_.begin(), found_.end(), [](const Departed& d) { return d.wrong; });
  if (first == found_.end()) return;
  throw ModelError(
      fmt::format("left the model: {}; what was written up to t = {:.6g} s is valid, later rows and "
                  "fields are not",
                  first->text, *valid_until_s()));
}

}  // namespace ricochet::coupler
