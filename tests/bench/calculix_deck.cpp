#include "tests/bench/calculix_deck.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "common/base/error.hpp"

namespace ricochet::bench {
namespace {

constexpr double angle = M_PI / 90.0;  // CalculiX's own for axisymmetric elements

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// CalculiX reads 20 characters of a number.
std::string number(double value) { return fmt::format("{:.12e}", value); }

/// One body in the deck's numbering: node n is `first_node + 2 n` in front and, off the axis, one more at the back.
struct DeckBody {
  const scene::BodyProblem& body;
  int first_node, first_element;

  [[nodiscard]] bool on_axis(int node) const { return body.mesh.position[at(node)][0] == 0.0; }
  [[nodiscard]] int front(int node) const { return first_node + 2 * node; }
  [[nodiscard]] int back(int node) const { return front(node) + (on_axis(node) ? 0 : 1); }
  [[nodiscard]] int nodes() const { return static_cast<int>(body.mesh.position.size()); }
  [[nodiscard]] int elements() const { return static_cast<int>(body.mesh.elements.size()); }
  /// The element's nodes, counter-clockwise; at the axis from the axis outwards: the first and the last lie on it.
  [[nodiscard]] std::array<int, 4> turned(int element) const {
    if (body.mesh.elements[at(element)].kind != fem::ElementKind::quadrilateral)
      throw ConfigError(fmt::format("body '{}', element {}: not a quadrilateral", body.name, element));
    std::array<int, 4> nodes{};
    std::copy_n(body.mesh.elements[at(element)].begin(), 4, nodes.begin());
    if (!touches_axis(nodes)) return nodes;
    for (int turn = 0; turn < 4; ++turn) {
      if (on_axis(nodes[0]) && on_axis(nodes[3]) && !on_axis(nodes[1]) && !on_axis(nodes[2])) return nodes;
      std::rotate(nodes.begin(), nodes.begin() + 1, nodes.end());
    }
    throw ConfigError(
        fmt::format("body '{}', element {}: touches the axis, but not with one edge", body.name, element));
  }
  [[nodiscard]] bool touches_axis(const std::array<int, 4>& nodes) const {
    return std::any_of(nodes.begin(), nodes.end(), [this](int node) { return on_axis(node); });
  }
};

void add_nodes(const DeckBody& body, std::string& deck) {
  for (int n = 0; n < body.nodes(); ++n) {
    const auto& x = body.body.mesh.position[at(n)];
    deck += fmt::format("{}, {}, {}, 0.\n", body.front(n), number(x[0]), number(x[1]));
    if (body.on_axis(n)) continue;
    deck += fmt::format("{}, {}, {}, {}\n", body.back(n), number(x[0] * std::cos(angle)), number(x[1]),
                        number(x[0] * std::sin(angle)));
  }
}

void add_elements(const DeckBody& body, std::string& deck) {
  std::string bricks, wedges;
  for (int e = 0; e < body.elements(); ++e) {
    const auto n = body.turned(e);
    const int id = body.first_element + e;
    if (body.on_axis(n[0])) {
      wedges += fmt::format("{}, {}, {}, {}, {}, {}, {}\n", id, body.front(n[0]), body.back(n[1]), body.front(n[1]),
                            body.front(n[3]), body.back(n[2]), body.front(n[2]));
    } else {
      bricks +=
          fmt::format("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", id, body.front(n[0]), body.front(n[1]), body.front(n[2]),
                      body.front(n[3]), body.back(n[0]), body.back(n[1]), body.back(n[2]), body.back(n[3]));
    }
  }
  const auto& name = body.body.name;
  if (!wedges.empty()) deck += fmt::format("*ELEMENT, TYPE=C3D6, ELSET={}\n{}", name, wedges);
  if (!bricks.empty()) deck += fmt::format("*ELEMENT, TYPE=C3D8, ELSET={}\n{}", name, bricks);
}

/// Faces of a surface, named as CalculiX does: the edges of the quadrilateral drawn through the angle.
std::string faces(const DeckBody& body, const std::string& surface) {
  static const std::array<const char*, 4> of_brick = {"S3", "S4", "S5", "S6"}, of_wedge = {"S1", "S4", "S2", ""};
  const auto& edges = body.body.mesh.surfaces.at(surface);
  std::string text;
  for (int e = 0; e < body.elements(); ++e) {
    const auto n = body.turned(e);
    for (std::size_t k = 0; k < 4; ++k) {
      const fem::Face edge = {n[k], n[(k + 1) % 4]};
      if (std::find(edges.begin(), edges.end(), edge) == edges.end()) continue;
      text += fmt::format("{}, {}\n", body.first_element + e, (body.on_axis(n[0]) ? of_wedge : of_brick)[k]);
    }
  }
  return text;
}

void add_supports(const DeckBody& body, std::string& deck) {
  deck += "*BOUNDARY\n";
  for (int n = 0; n < body.nodes(); ++n) {
    deck += fmt::format("{}, 3\n", body.front(n));  // stays in its plane
    for (int c = 0; c < 2; ++c) {
      if (body.body.fixed_dof[at(2 * n + c)]) deck += fmt::format("{}, {}\n", body.front(n), c + 1);
    }
  }
}

/// The back is the front, turned.
void add_ties(const DeckBody& body, std::string& deck) {
  const auto tie = [&](int back, int component, int front, int to, double factor) {
    deck += fmt::format("*EQUATION\n2\n{}, {}, 1., {}, {}, {}\n", back, component, front, to, number(-factor));
  };
  for (int n = 0; n < body.nodes(); ++n) {
    if (body.on_axis(n)) continue;
    tie(body.back(n), 1, body.front(n), 1, std::cos(angle));
    tie(body.back(n), 2, body.front(n), 2, 1.0);
    tie(body.back(n), 3, body.front(n), 1, std::sin(angle));
  }
}

void add_material(const DeckBody& body, std::string& deck) {
  const auto& material = body.body.material;
  deck +=
      fmt::format("*MATERIAL, NAME={0}\n*ELASTIC\n{1}, {2}\n*DENSITY\n{3}\n*SOLID SECTION, ELSET={0}, MATERIAL={0}\n",
                  body.body.name, number(material.youngs_modulus_pa), number(material.poisson_ratio),
                  number(material.density_kg_m3));
}

void add_velocities(const DeckBody& body, std::string& deck) {
  const auto& velocity = body.body.initial_velocity_m_s;
  for (int n = 0; n < body.nodes(); ++n) {
    const double radial = velocity[2 * n], axial = velocity[2 * n + 1];
    if (radial != 0.0) {
      deck += fmt::format("{}, 1, {}\n", body.front(n), number(radial));
      deck += fmt::format("{}, 1, {}\n", body.back(n), number(radial * std::cos(angle)));
      deck += fmt::format("{}, 3, {}\n", body.back(n), number(radial * std::sin(angle)));
    }
    if (axial == 0.0) continue;
    deck += fmt::format("{}, 2, {}\n", body.front(n), number(axial));
    if (!body.on_axis(n)) deck += fmt::format("{}, 2, {}\n", body.back(n), number(axial));
  }
}

double shortest_edge_m(const fem::Mesh& mesh, const std::string& surface) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const fem::Face& edge : mesh.surfaces.at(surface)) {
    shortest = std::min(shortest, (mesh.position[at(edge[1])] - mesh.position[at(edge[0])]).norm());
  }
  return shortest;
}

void add_contact(const scene::Contact& contact, const DeckBody& a, const DeckBody& b, std::string& deck) {
  const double softer = std::min(a.body.material.youngs_modulus_pa, b.body.material.youngs_modulus_pa);
  const std::string stiffness = number(softer / shortest_edge_m(a.body.mesh, contact.first.surface));
  deck += fmt::format("*SURFACE, NAME=FIRST\n{}*SURFACE, NAME=SECOND\n{}", faces(a, contact.first.surface),
                      faces(b, contact.second->surface));
  deck += fmt::format("*SURFACE INTERACTION, NAME=CONTACT\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{}\n",
                      stiffness);
  if (contact.friction_coefficient > 0.0) {
    deck += fmt::format("*FRICTION\n{}, {}\n", number(contact.friction_coefficient), stiffness);
  }
  deck += "*CONTACT PAIR, INTERACTION=CONTACT, TYPE=SURFACE TO SURFACE\nFIRST, SECOND\n";
}

void require(bool holds, const scene::Scene& scene, const char* allowed) {
  if (!holds) throw ConfigError(fmt::format("{}: a deck for CalculiX is written of {} only", scene.path, allowed));
}

}  // namespace

std::string calculix_deck(const scene::Problem& problem, long steps) {
  const auto& scene = problem.scene;
  const auto& contact = problem.contacts.front();
  require(scene.model == scene::Model::axisymmetric, scene, "axisymmetric scenes");
  require(contact.body_a >= 0 && contact.body_b >= 0, scene, "the contact of two bodies");
  require(scene.contacts.front().initial_gap_m == 0.0 && scene.contacts.front().nose_radius_m == 0.0, scene,
          "contact without a gap");
  for (const auto& body : scene.bodies) {
    const bool heavy =
        std::any_of(body.gravity_m_s2.begin(), body.gravity_m_s2.end(), [](double g) { return g != 0.0; });
    require(body.tractions.empty() && body.prescribed.empty() && !heavy, scene, "bodies without loads");
  }
  std::vector<DeckBody> bodies;
  int node = 1, element = 1;
  for (const auto& body : problem.bodies) {
    bodies.push_back({body, node, element});
    node += 2 * bodies.back().nodes();
    element += bodies.back().elements();
  }
  std::string deck = "*NODE\n";
  for (const auto& body : bodies) add_nodes(body, deck);
  for (const auto& body : bodies) add_elements(body, deck);
  for (const auto& body : bodies) add_supports(body, deck);
  for (const auto& body : bodies) add_ties(body, deck);
  for (const auto& body : bodies) add_material(body, deck);
  deck += "*INITIAL CONDITIONS, TYPE=VELOCITY\n";
  for (const auto& body : bodies) add_velocities(body, deck);
  add_contact(scene.contact_law(), bodies[at(contact.body_a)], bodies[at(contact.body_b)], deck);
  deck += fmt::format("*STEP, INC=1000000\n*DYNAMIC, DIRECT, ALPHA=0.\n{}, {}\n", number(problem.clock.size_s()),
                      number(static_cast<double>(steps) * problem.clock.size_s()));
  return deck + "*CONTACT PRINT, SLAVE=FIRST, MASTER=SECOND, FREQUENCY=1\nCF\n*END STEP\n";
}

PressureHistory calculix_pressure(const std::string& results) {
  PressureHistory history;
  std::istringstream lines(results);
  bool wanted = false;
  double time_s = 0.0;
  for (std::string line; std::getline(lines, line);) {
    const auto at_time = line.find("and time");
    if (line.find("statistics for slave set") != std::string::npos && at_time != std::string::npos) {
      time_s = std::stod(line.substr(at_time + 8));
    } else if (line.find("area,  normal force") != std::string::npos) {
      wanted = true;
    } else if (wanted && line.find_first_not_of(' ') != std::string::npos) {
      double area_m2 = 0.0, tension_n = 0.0;
      if (!(std::istringstream(line) >> area_m2 >> tension_n)) {
        throw ParticipantError(fmt::format("CalculiX's contact forces: found \"{}\", expected area and force", line));
      }
      history.time_s.push_back(time_s);
      history.pressure_pa.push_back(-tension_n / area_m2);
      wanted = false;
    }
  }
  return history;
}

}  // namespace ricochet::bench
