#include "coupler/watch/tried_causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "coupler/interface/vectors.hpp"

namespace ricochet::coupler {
namespace {

/// Coordinates exchanged and mirrored: coordinate c is `sign[c]` times what stands at `axis[c]`.
struct Turn {
  std::vector<std::size_t> axis;
  std::vector<double> sign;
};

/// All but the one that changes nothing.
std::vector<Turn> turns(std::size_t components) {
  std::vector<Turn> result;
  std::vector<std::size_t> axis(components);
  std::iota(axis.begin(), axis.end(), std::size_t{0});
  do {
    for (unsigned mirrored = 0; mirrored < 1U << components; ++mirrored) {
      Turn turn{axis, {}};
      for (std::size_t c = 0; c < components; ++c) turn.sign.push_back((mirrored >> c & 1U) != 0U ? -1.0 : 1.0);
      result.push_back(turn);
    }
  } while (std::next_permutation(axis.begin(), axis.end()));
  result.erase(result.begin());
  return result;
}

/// "(y, -x)"
std::string turn_text(const Turn& turn, const std::vector<std::string>& axes) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < axes.size(); ++c) names.push_back((turn.sign[c] < 0.0 ? "-" : "") + axes[turn.axis[c]]);
  return fmt::format("({})", fmt::join(names, ", "));
}

/// Other orders of all nodes, of those of each body, by component in place of by node.
std::vector<Arrangement> other_orders(const std::vector<double>& bodies, std::size_t components) {
  const std::size_t nodes = bodies.size();
  std::vector<Arrangement> orders{{"the order of the nodes is reversed", {}, {}},
                                  {"the order of the nodes of each body is reversed", {}, {}},
                                  {"rows go by node, as if they went by component", {}, {}},
                                  {"rows go by component, not by node", {}, {}}};
  for (std::size_t i = 0; i < nodes; ++i) {
    const auto same = [&](double body) { return body == bodies[i]; };
    const auto first = std::find_if(bodies.begin(), bodies.end(), same) - bodies.begin(),
               last = bodies.rend() - std::find_if(bodies.rbegin(), bodies.rend(), same) - 1;
    for (std::size_t c = 0; c < components; ++c) {
      orders[0].row.push_back((nodes - 1 - i) * components + c);
      orders[1].row.push_back((static_cast<std::size_t>(first + last) - i) * components + c);
      orders[2].row.push_back(c * nodes + i);
    }
  }
  orders[3].row.resize(orders[2].row.size());
  for (std::size_t i = 0; i < orders[2].row.size(); ++i) orders[3].row[orders[2].row[i]] = i;
  if (components == 1) orders.resize(2);
  for (auto& order : orders) order.sign.assign(nodes * components, 1.0);
  return orders;
}

}  // namespace

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

bool agree(const std::vector<double>& found, const std::vector<double>& expected) {
  return (view(found) - view(expected)).cwiseAbs().maxCoeff() <= comparison_tolerance * largest(expected);
}

std::optional<double> common_factor(const std::vector<double>& found, const std::vector<double>& expected) {
  const double factor = view(found).dot(view(expected)) / view(expected).squaredNorm();
  const double rest = (view(found) - factor * view(expected)).cwiseAbs().maxCoeff();
  if (!std::isfinite(factor) || rest > comparison_tolerance * std::abs(factor) * largest(expected)) return std::nullopt;
  return factor;
}

std::string known_slip(double ratio) {
  const auto is = [ratio](double value) { return std::abs(ratio / value - 1.0) <= comparison_tolerance; };
  if (is(-1.0)) return "its sign is wrong (P resists a positive displacement; L acts with a minus)";
  if (is(0.5 * M_1_PI)) return "it is per radian, it must be that of the full circle";
  if (is(2.0 * M_PI)) return "it is that of 2 pi full circles: 2 pi was multiplied twice";
  for (const double unit : {1e3, 1e6, 1e9, 1e12}) {
    if (is(unit) || is(1.0 / unit))
      return fmt::format("a factor {:g}: everything is in SI units (m, kg, s, N)", ratio > 1.0 ? unit : 1.0 / unit);
  }
  return "";
}

std::vector<double> Arrangement::applied(const std::vector<double>& values) const {
  std::vector<double> result;
  for (std::size_t i = 0; i < row.size(); ++i) result.push_back(sign[i] * values[row[i]]);
  return result;
}

std::vector<double> Arrangement::undone(const std::vector<double>& values) const {
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < row.size(); ++i) result[row[i]] = sign[i] * values[i];
  return result;
}

std::vector<Arrangement> other_arrangements(const std::vector<double>& bodies, const std::vector<std::string>& axes) {
  auto arrangements = other_orders(bodies, axes.size());
  for (const auto& turn : turns(axes.size())) {
    auto& turned = arrangements.emplace_back();
    turned.name = fmt::format("components are taken as {}", turn_text(turn, axes));
    for (std::size_t i = 0; i < bodies.size() * axes.size(); ++i) {
      const std::size_t c = i % axes.size();
      turned.row.push_back(i - c + turn.axis[c]);
      turned.sign.push_back(turn.sign[c]);
    }
  }
  return arrangements;
}

std::string places_cause(const std::vector<Eigen::Vector3d>& places, const std::vector<std::string>& axes,
                         const std::function<bool(std::size_t, const Eigen::Vector3d&)>& is_there) {
  auto tried = turns(axes.size());
  Turn none{{}, std::vector<double>(axes.size(), 1.0)};
  for (std::size_t c = 0; c < axes.size(); ++c) none.axis.push_back(c);
  tried.insert(tried.begin(), none);
  for (const double scale : {1.0, 1e-3, 1e3}) {
    for (std::size_t t = 0; t < tried.size(); ++t) {
      if (scale == 1.0 && t == 0) continue;
      std::size_t there = 0;
      for (; there < places.size(); ++there) {
        Eigen::Vector3d x = Eigen::Vector3d::Zero();
        for (std::size_t c = 0; c < axes.size(); ++c)
          x[static_cast<Eigen::Index>(c)] =
              scale * tried[t].sign[c] * places[there][static_cast<Eigen::Index>(tried[t].axis[c])];
        if (!is_there(there, x)) break;
      }
      if (there < places.size()) continue;
      const auto unit = scale == 1.0 ? "" : fmt::format("{:g} times ", scale);
      const auto whose =
          places.size() == 1 ? "its node is a place" : fmt::format("all {} nodes are places", places.size());
      return fmt::format("{}{} of {} of the scene{}", unit, turn_text(tried[t], axes), whose,
                         scale == 1.0 ? "" : ", which has metres");
    }
  }
  return "";
}

std::string as_cause(const std::string& text) { return text.empty() ? "" : "; likely cause: " + text; }

}  // namespace ricochet::coupler
