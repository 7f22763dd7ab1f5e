#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "coupler/interface/coupling.hpp"

namespace ricochet::coupler::test {

/// Free springs and masses on a line, one component per node.
struct Chain {
  Eigen::VectorXd mass;
  Eigen::MatrixXd stiffness;
  Eigen::VectorXd position;

  /// `springs` between neighbours; every spring gives half of its mass to either end.
  static Chain of(const std::vector<double>& springs, const std::vector<double>& spring_mass, double start) {
    const auto nodes = static_cast<Eigen::Index>(springs.size()) + 1;
    Chain chain{Eigen::VectorXd::Zero(nodes), Eigen::MatrixXd::Zero(nodes, nodes), Eigen::VectorXd::Zero(nodes)};
    for (Eigen::Index i = 0; i < nodes; ++i) chain.position[i] = start + static_cast<double>(i);
    for (std::size_t s = 0; s < springs.size(); ++s) {
      const auto i = static_cast<Eigen::Index>(s);
      chain.mass[i] += 0.5 * spring_mass[s];
      chain.mass[i + 1] += 0.5 * spring_mass[s];
      chain.stiffness(i, i) += springs[s];
      chain.stiffness(i + 1, i + 1) += springs[s];
      chain.stiffness(i, i + 1) -= springs[s];
      chain.stiffness(i + 1, i) -= springs[s];
    }
    return chain;
  }
};

/// A participant in this process that answers messages as the real ones do: a chain of which some nodes are shared.
/// Explicit: central difference on the nodes that are not shared. Implicit: trapezoidal rule (or central difference
/// after a synchronisation that asks for it) on all nodes, with the summed masses. Driven by force, the explicit one
/// integrates all its nodes, in substeps.
class FakeParticipant {
 public:
  FakeParticipant(std::string name, bool implicit, Chain chain, std::vector<int> shared, Eigen::VectorXd velocity)
      : name_(std::move(name)),
        implicit_(implicit),
        chain_(std::move(chain)),
        shared_(std::move(shared)),
        u(Eigen::VectorXd::Zero(velocity.size())),
        v(std::move(velocity)),
        a(Eigen::VectorXd::Zero(v.size())) {
    const auto n = static_cast<Eigen::Index>(shared_.size());
    link_accepted_ = link_trial_ = output_accepted_ = output_ = Eigen::VectorXd::Zero(n);
  }

  [[nodiscard]] PeerDescription description() const {
    PeerDescription d;
    d.participant = name_;
    d.role = implicit_ ? Role::implicit_solver : Role::explicit_solver;
    d.components = 1;
    d.bodies = {"chain"};
    d.record_columns = {"window"};
    d.contact_owner = implicit_;
    const int n = static_cast<int>(shared_.size());
    d.interface_body = {n, 1, std::vector<double>(shared_.size(), 0.0)};
    d.interface_position_m = {n, 1, {}};
    d.interface_mass_kg = {n, 1, {}};
    for (const int node : shared_) {
      d.interface_position_m.data.push_back(chain_.position[node]);
      d.interface_mass_kg.data.push_back(chain_.mass[node]);
    }
    return d;
  }

  [[nodiscard]] Peer peer() {
    return {name_, [this](wire::Message& message) { handle(message); }, [this]() -> wire::Message& { return answer_; }};
  }

  /// Momentum of the nodes that this participant integrates.
  [[nodiscard]] double momentum() const { return integrated_mass().dot(v); }
  [[nodiscard]] double energy() const {
    return 0.5 * v.dot(integrated_mass().cwiseProduct(v)) + 0.5 * u.dot(chain_.stiffness * u);
  }
  /// 1/2 a.(M - (1/4 - beta) h^2 K) a + 1/2 v.K v, h the step: what Newmark's rule with gamma = 1/2 keeps where dv.df =
  /// 0.
  [[nodiscard]] double pseudo_energy() const {
    const double h = dt_ / substeps_, factor = implicit_ ? 0.0 : 0.25 * h * h;
    return 0.5 * a.dot(chain_.mass.cwiseProduct(a) - factor * (chain_.stiffness * a)) +
           0.5 * v.dot(chain_.stiffness * v);
  }

  Eigen::VectorXd integrated_mass() const {
    Eigen::VectorXd mass = chain_.mass;
    if (!moves()) {
      for (const int node : shared_) mass[node] = 0.0;
    }
    return mass;
  }

  double corrupt_increment = 0.0;   ///< added to every answered increment: a drift that a resynchronisation must find
  wire::ContactReport status;       ///< of the next answers
  std::vector<std::string> asked;   ///< kinds of messages, in order
  wire::Array departures, outline;  ///< what it tells with its history rows
  std::int64_t finish_at = -1;
  bool forgets_to_restore = false;  ///< a repeated window starts where the last trial ended

 private:
  void handle(const wire::Message& m) {
    asked.emplace_back(wire::name(m.kind));
    if (m.kind == wire::Kind::initialize) {
      initialize(m.as<wire::Initialize>(), answer_.make<wire::Initialized>());
    } else if (m.kind == wire::Kind::synchronise) {
      synchronise(m.as<wire::Synchronise>(), answer_.make<wire::Synchronised>());
    } else if (m.kind == wire::Kind::advance) {
      advance(m, m.as<wire::Advance>(), answer_.make<wire::Advanced>());
    } else if (m.kind == wire::Kind::accept) {
      static_cast<wire::ContactReport&>(answer_.make<wire::Accepted>()) = status;
      answer_.window = m.window;
      accept();
    } else if (m.kind == wire::Kind::load_state) {
      answer_.make<wire::StateLoaded>();
      exchange_motion(
          [next = m.as<wire::LoadState>().state.data.begin()](double& value, double) mutable { value = *next++; });
    } else if (m.kind == wire::Kind::read_state) {
      auto& answer = answer_.make<wire::State>();
      answer.state = answer.state_scale = {0, 1, {}};
      exchange_motion([&answer](double& value, double scale) {
        answer.state.data.push_back(value);
        answer.state_scale.data.push_back(scale);
      });
    } else if (m.kind == wire::Kind::finish) {
      answer_.make<wire::Finished>();
    }
  }

  void initialize(const wire::Initialize& m, wire::Initialized& answer) {
    dt_ = m.window_size_s;
    driven_by_force_ = m.driven_by == "force";
    substeps_ = static_cast<int>(m.substeps);
    const auto& s = m.interface_stiffness;
    interface_stiffness_ = Eigen::Map<const Eigen::MatrixXd>(s.data.data(), s.rows, s.columns);
    for (std::size_t i = 0; i < shared_.size(); ++i) chain_.mass[shared_[i]] = m.interface_mass_kg.data[i];
    output_accepted_ = output_ = own_output();
    set(answer.absolute, output_);
  }

  /// u, then v of what it integrates, each with its scale.
  template <class Exchange>
  void exchange_motion(Exchange exchange) {
    const Eigen::VectorXd mass = integrated_mass();
    for (auto* values : {&u, &v}) {
      for (Eigen::Index i = 0; i < mass.size(); ++i) {
        if (mass[i] > 0.0) exchange((*values)[i], std::sqrt(mass[i]) / (values == &u ? dt_ : 1.0));
      }
    }
  }

  void synchronise(const wire::Synchronise& m, wire::Synchronised& answer) {
    explicit_now_ = m.integration == "explicit_central";
    link_accepted_ = Eigen::Map<const Eigen::VectorXd>(m.link_absolute.data.data(), link_accepted_.size());
    if (!moves()) put_shared(u, link_accepted_);
    acceleration_from(u, link_accepted_ + stiffness_force(u), a);
    output_accepted_ = output_ = own_output();
    set(answer.absolute, output_);
    if (moves()) answer_motion(v, a, answer);
    u1 = u, v1 = v, a1 = a;
  }

  void advance(const wire::Header& header, const wire::Advance& m, wire::Advanced& answer) {
    const Eigen::VectorXd increment =
        Eigen::Map<const Eigen::VectorXd>(m.link_increment.data.data(), link_accepted_.size());
    link_trial_ = link_accepted_ + increment;
    if (m.link_absolute.rows > 0) {
      link_trial_ = Eigen::Map<const Eigen::VectorXd>(m.link_absolute.data.data(), link_accepted_.size());
    }
    if (!forgets_to_restore) u1 = u, v1 = v, a1 = a;
    if (implicit_) {
      step_implicit();
    } else if (driven_by_force_) {
      subcycle(header.substep == 0 ? substeps_ : 1);
    } else {
      u1 = u + dt_ * v + 0.5 * dt_ * dt_ * a;
      put_shared(u1, link_trial_);
      acceleration_from(u1, link_trial_, a1);
      v1 = v + 0.5 * dt_ * (a + a1);
      for (const int node : shared_) v1[node] = a1[node] = 0.0;
    }
    output_ = moves() ? shared_part(u1) : shared_part(chain_.stiffness * u1);
    static_cast<wire::ContactReport&>(answer) = status;
    if (moves()) answer_motion(v1, a1, answer);
    answer_.window = header.window + m.windows - 1;
    set(answer.increment, output_ - output_accepted_);
    for (auto& value : answer.increment.data) value += corrupt_increment;
    answer.absolute = {0, 1, {}};
    if (m.absolute_requested) set(answer.absolute, output_);
    answer.finished_early = finish_at >= 0 && answer_.window >= finish_at;
    answer.records.resize(0, 1);
    for (; m.records_requested && next_row_ <= answer_.window; ++next_row_) {
      answer.records.resize(answer.records.rows + 1, 1);
      answer.records.data.back() = static_cast<double>(next_row_);
    }
    if (m.records_requested) answer.departures = departures, answer.outline = outline;
    if (m.accept_at_once) accept();
  }

  void accept() {
    u = u1, v = v1, a = a1;
    link_accepted_ = link_trial_;
    output_accepted_ = output_;
  }

  void answer_motion(const Eigen::VectorXd& velocity, const Eigen::VectorXd& acceleration, wire::Rates& answer) const {
    set(answer.velocity_m_s, shared_part(velocity));
    set(answer.acceleration_m_s2, shared_part(acceleration));
  }

  void subcycle(int steps) {
    const double h = dt_ / substeps_;
    for (int j = 1; j <= steps; ++j) {
      u1 += h * v1 + 0.5 * h * h * a1;
      const Eigen::VectorXd last = a1;
      const double share = static_cast<double>(j) / steps;
      acceleration_from(u1, link_accepted_ + share * (link_trial_ - link_accepted_), a1);
      v1 += 0.5 * h * (last + a1);
    }
  }

  void step_implicit() {
    const double beta = explicit_now_ ? 0.0 : 0.25;
    u1 = u + dt_ * v + (0.5 - beta) * dt_ * dt_ * a;
    Eigen::MatrixXd lhs = beta * dt_ * dt_ * chain_.stiffness;
    lhs.diagonal() += chain_.mass;
    Eigen::VectorXd rhs = -chain_.stiffness * u1;
    const Eigen::VectorXd link = link_trial_ + stiffness_force(u1);
    for (std::size_t i = 0; i < shared_.size(); ++i) {
      rhs[shared_[i]] -= link[static_cast<Eigen::Index>(i)];
      for (std::size_t j = 0; j < shared_.size() && interface_stiffness_.size() > 0; ++j) {
        lhs(shared_[i], shared_[j]) +=
            beta * dt_ * dt_ * interface_stiffness_(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
    }
    a1 = lhs.ldlt().solve(rhs);
    u1 += beta * dt_ * dt_ * a1;
    v1 = v + 0.5 * dt_ * (a + a1);
  }

  void acceleration_from(const Eigen::VectorXd& at, const Eigen::VectorXd& link, Eigen::VectorXd& result) const {
    Eigen::VectorXd force = -chain_.stiffness * at;
    for (std::size_t i = 0; moves() && i < shared_.size(); ++i) {
      force[shared_[i]] += (implicit_ ? -1.0 : 1.0) * link[static_cast<Eigen::Index>(i)];
    }
    result = force.cwiseQuotient(chain_.mass);
    if (moves()) return;
    for (const int node : shared_) result[node] = 0.0;
  }

  [[nodiscard]] Eigen::VectorXd own_output() const {
    return moves() ? shared_part(u) : shared_part(chain_.stiffness * u);
  }
  [[nodiscard]] bool moves() const { return implicit_ || driven_by_force_; }
  [[nodiscard]] Eigen::VectorXd stiffness_force(const Eigen::VectorXd& at) const {
    if (interface_stiffness_.size() == 0) return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(shared_.size()));
    return interface_stiffness_ * shared_part(at);
  }
  [[nodiscard]] Eigen::VectorXd shared_part(const Eigen::VectorXd& values) const {
    Eigen::VectorXd part(static_cast<Eigen::Index>(shared_.size()));
    for (std::size_t i = 0; i < shared_.size(); ++i) part[static_cast<Eigen::Index>(i)] = values[shared_[i]];
    return part;
  }
  void put_shared(Eigen::VectorXd& values, const Eigen::VectorXd& part) const {
    for (std::size_t i = 0; i < shared_.size(); ++i) values[shared_[i]] = part[static_cast<Eigen::Index>(i)];
  }
  static void set(wire::Array& array, const Eigen::VectorXd& values) {
    array = {static_cast<int>(values.size()), 1, std::vector<double>(values.data(), values.data() + values.size())};
  }

  std::string name_;
  bool implicit_;
  Chain chain_;
  std::vector<int> shared_;
  wire::Message answer_;
  std::int64_t next_row_ = 0;  ///< of history
  Eigen::VectorXd link_accepted_, link_trial_, output_accepted_, output_;
  Eigen::VectorXd u1, v1, a1;  ///< of the trial
  Eigen::MatrixXd interface_stiffness_;
  double dt_ = 0.0;
  int substeps_ = 1;
  bool explicit_now_ = false, driven_by_force_ = false;

 public:
  Eigen::VectorXd u, v, a;
};

/// Fakes coupled in this process, not started yet.
inline std::unique_ptr<Coupling> unstarted(const std::vector<FakeParticipant*>& participants, double dt) {
  std::vector<PeerDescription> descriptions;
  for (const auto* p : participants) descriptions.push_back(p->description());
  std::vector<Peer> peers;
  for (auto* p : participants) peers.push_back(p->peer());
  return std::make_unique<Coupling>(std::move(peers), descriptions, dt);
}

/// The same, started as the primal protocols do.
inline std::unique_ptr<Coupling> couple(const std::vector<FakeParticipant*>& participants, double dt) {
  auto coupling = unstarted(participants, dt);
  wire::Initialize request;
  request.window_size_s = dt;
  coupling->initialize(request);
  return coupling;
}

}  // namespace ricochet::coupler::test
