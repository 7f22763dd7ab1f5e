#include "coupler/watch/outside_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "common/base/error.hpp"

namespace ricochet::coupler {
namespace {

struct Kind {
  const char* name;
  bool wrong;
};
/// In the order of the wire's numbers, from 1.
constexpr std::array<Kind, 8> kinds = {{{"strain", false},
                                        {"rotation", false},
                                        {"slip", false},
                                        {"inverted_element", true},
                                        {"off_partner", true},
                                        {"penetration", true},
                                        {"yield", false},
                                        {"tension", false}}};

constexpr const char* go_on = "coupling.outside_model = \"go_on\"";

std::array<double, 3> numbers(const Eigen::Vector3d& place) { return {place[0], place[1], place[2]}; }

/// That of the element whose middle is nearest to a place.
const fem::Material& material_in(const scene::BodyProblem& body, const std::array<double, 3>& place_m) {
  if (body.mesh.material.empty()) return body.material;
  const Eigen::Vector3d place(place_m.data());
  double nearest = std::numeric_limits<double>::infinity();
  int element = 0;
  for (int e = 0; e < static_cast<int>(body.mesh.elements.size()); ++e) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    const fem::Element& nodes = body.mesh.elements[fem::at(e)];
    for (const int node : nodes) middle += body.mesh.position[fem::at(node)] / static_cast<double>(nodes.size());
    if (const double away = (middle - place).squaredNorm(); away < nearest)
      std::tie(nearest, element) = std::pair(away, e);
  }
  return fem::material_of(body, element);
}

}  // namespace

std::string OutsideModel::place(const Departed& d) const {
  return fmt::format("in body '{}' at {}, t = {:.6g} s", d.body,
                     fem::place_text(problem_.scene.model, Eigen::Vector3d(d.place_m.data())), d.time_s);
}

/// The text on a stress and the limit of the body's material; a foreign body has none that the scene knows.
std::string OutsideModel::stress_text(const Departed& d) const {
  const bool yields = d.kind == "yield";
  const auto body = std::find_if(problem_.bodies.begin(), problem_.bodies.end(),
                                 [&](const scene::BodyProblem& b) { return b.name == d.body; });
  std::string against = yields ? "above its yield stress" : "above its strength";
  if (body != problem_.bodies.end()) {
    const fem::Material& material = material_in(*body, d.place_m);
    const double limit = yields ? material.yield_stress_pa : material.strength_pa;
    against = fmt::format("{:.4g} times its {} of {:.4g} MPa", d.size / limit, yields ? "yield stress" : "strength",
                          1e-6 * limit);
  }
  return fmt::format(
      "{} of {:.4g} MPa {}, {}; first passed between t = {:.6g} s and {:.6g} s, at {}, by {:.4g} MPa: {}",
      yields ? "von Mises stress" : "tension", 1e-6 * d.size, place(d), against, d.within_s, d.first_s,
      fem::place_text(problem_.scene.model, Eigen::Vector3d(d.first_place_m.data())), 1e-6 * d.first_size,
      yields ? "a metal flows there, linear elastic elements do not, and what follows is too stiff"
             : "a brittle body breaks there, linear elastic elements do not");
}

/// By more than an error that can be told.
bool OutsideModel::too_far(const Departed& d) const {
  if (problem_.scene.coupling.outside_model == scene::OutsideModel::go_on) return false;
  return (d.kind == "strain" && d.size >= strain_limit) || (d.kind == "rotation" && d.size >= rotation_limit);
}

std::string OutsideModel::text_of(const Departed& d) const {
  if (d.kind == "strain") {
    return fmt::format(
        "strain of {:.3g} % {}: strain is small no more, expect errors of stresses and forces of "
        "about {:.2g} %",
        100 * d.size, place(d), 100 * d.size);
  }
  if (d.kind == "rotation") {
    const scene::Scene& scene = problem_.scene;
    const bool in_frame = !scene.is_foreign(d.body) && scene.body(d.body).large_rotation;
    const bool may_turn = scene.model == scene::Model::plane_strain || scene.model == scene::Model::solid;
    return fmt::format(
        "rotation of {:.3g} degrees {}: small displacement{} knows no turning, so the body grows there "
        "by {:.2g} % of its size, with no stress of it, and its stresses keep the directions of the {}{}",
        d.size * 180.0 / std::numbers::pi, place(d), in_frame ? " in the frame that turns with the body" : "",
        100.0 * (1.0 / std::cos(std::min(d.size, 1.5)) - 1.0), in_frame ? "frame" : "start",
        may_turn && !in_frame ? "; a body that turns as a whole takes large_rotation = true" : "");
  }
  if (d.kind == "yield" || d.kind == "tension") return stress_text(d);
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
         .place_m = numbers(overlap.place),
         .first_size = overlap.depth_m,
         .first_place_m = numbers(overlap.place),
         .looks = 1,
         .wrong = true,
         .text = fmt::format("bodies '{}' and '{}' overlap by {:.3g} m at {}, t = {:.6g} s, {}", overlap.body,
                             overlap.other, overlap.depth_m, fem::place_text(problem_.scene.model, overlap.place),
                             overlap.time_s,
                             overlap.beside_contact ? "beside the surfaces that the contact names: what may touch has "
                                                      "to belong to them"
                                                    : "with no contact between them")},
        news);
  }
  last_update_s_ = problem_.clock.time_s(window);
  return news;
}

void OutsideModel::take(const Link& link, std::vector<std::string>& news) {
  const auto& told = link.departures();
  const auto end_of = [this](double window) { return problem_.clock.time_s(static_cast<std::int64_t>(window)); };
  for (int row = 0; row < told.rows; ++row) {
    const double* v = &told.data[static_cast<std::size_t>(row * wire::departure_columns)];
    const Kind& kind = kinds[static_cast<std::size_t>(v[0]) - 1];
    Departed departed{.kind = kind.name,
                      .body = link.description().bodies[static_cast<std::size_t>(v[1])],
                      .size = v[5],
                      .first_s = end_of(v[3]),
                      .time_s = end_of(v[6]),
                      .within_s = end_of(v[2]),
                      .place_m = {v[7], v[8], v[9]},
                      .first_size = v[10],
                      .first_place_m = {v[11], v[12], v[13]},
                      .looks = static_cast<std::int64_t>(v[4]),
                      .wrong = kind.wrong,
                      .text = {}};
    departed.wrong = departed.wrong || too_far(departed);
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
  if (known->first_s <= departed.first_s) {
    departed.first_s = known->first_s;
    departed.first_size = known->first_size;
    departed.first_place_m = known->first_place_m;
  }
  // A departure that has only now become wrong was none at the last look.
  const bool now_wrong = departed.wrong && !known->wrong;
  departed.within_s = now_wrong ? last_update_s_ : std::min(departed.within_s, known->within_s);
  departed.wrong = departed.wrong || known->wrong;
  departed.looks = std::max(departed.looks, known->looks);
  if (departed.size < known->size) {
    departed.size = known->size;
    departed.time_s = known->time_s;
    departed.place_m = known->place_m;
    departed.text = known->text;
  }
  if (departed.kind == "yield" || departed.kind == "tension") departed.text = stress_text(departed);
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
  const bool by_choice = first->kind == "strain" || first->kind == "rotation";
  throw ModelError(
      fmt::format("left the model: {}; what was written up to t = {:.6g} s is valid, later rows and "
                  "fields are not{}",
                  first->text, *valid_until_s(), by_choice ? fmt::format("; to go on for all that: {}", go_on) : ""));
}

}  // namespace ricochet::coupler
