#include "coupler/protocols/gravouil_combescure.hpp"

#include <algorithm>
#include <string>

#include "common/base/archive.hpp"
#include "coupler/interface/vectors.hpp"
#include "coupler/protocols/unit_response.hpp"

namespace ricochet::coupler {
namespace {

/// A participant that owns the contact and can be put back is at rest meanwhile, without loads and with its contact
/// open: else the answers to probes are those of the contact of the start, too, which with friction are not linear.
class OpenContact {
 public:
  explicit OpenContact(Link& link) : link_(link) {
    const auto& can = link.description().capabilities;
    const auto has = [&](Capability c) { return std::find(can.begin(), can.end(), name_of(c)) != can.end(); };
    able_ = link.description().contact_owner && has(Capability::load_state) && has(Capability::save_state);
    if (!able_) return;
    Archive here;
    link_.archive(here);
    here_ = here.take();
    link_.post_save_state();
    saved_ = link_.wait_saved_state();
    link_.post_read_state();
    const std::size_t size = link_.wait_state().state.data.size();
    link_.post_load_state(std::vector<double>(size, 0.0), FrozenContact::open);
    link_.wait_state_loaded();
    rest();
  }
  /// It goes on from where it was; at the start a synchronisation must follow.
  void give_back() {
    if (!able_) return;
    rest();  // drops the trial
    link_.post_restore_state(saved_);
    link_.wait_state_restored();
    Archive here(here_, "this end of the link");
    link_.archive(here);
  }

 private:
  void rest() {
    link_.post_synchronise(Integration::implicit_newmark, std::vector<double>(link_.input().size(), 0.0));
    link_.wait_synchronised();
  }
  Link& link_;
  bool able_ = false;
  std::string saved_, here_;
};

}  // namespace

void GravouilCombescure::start(Coupling& coupling, const wire::Initialize& request) {
  interface_.start(coupling, request, Step{.substep = 1, .ends_window = substeps_ == 1});
  measure_implicit(coupling);
  coupling.synchronise_implicit(to_vector(interface_.multiplier()));
}

void GravouilCombescure::reconfigure(Coupling& coupling) {
  interface_.reconfigure(coupling,
                         Step{.accepted_window = coupling.window(), .substep = 1, .ends_window = substeps_ == 1});
  measure_implicit(coupling);
}

void GravouilCombescure::measure_implicit(Coupling& coupling) {
  auto& implicit = *coupling.implicit_link();
  // The response to a force includes the answer of the link's stiffness, R = (I + H_i Z)^-1 H_i; H_i = R (I - Z R)^-1.
  const std::vector<double> probes = to_vector(view(implicit.own_mass_kg()) / coupling.window_size_s());
  OpenContact open(implicit);
  const Eigen::MatrixXd response =
      unit_response(implicit, Response::velocity, Step{.accepted_window = coupling.window()}, probes);
  open.give_back();
  const auto size = response.rows();
  Eigen::MatrixXd r = Eigen::MatrixXd::Zero(size, size);
  implicit.rows().add_matrix(-response, r);
  const auto identity = Eigen::MatrixXd::Identity(size, size);
  implicit_operator_ = (identity - r * interface_.impedance()).partialPivLu().solve(r);
  factorise();
}

void GravouilCombescure::factorise() {
  const auto size = implicit_operator_.rows();
  velocity_problem_.compute(Eigen::MatrixXd::Identity(size, size) + implicit_operator_ * interface_.impedance());
}

void GravouilCombescure::archive(Archive& a) {
  interface_.archive(a);
  if (!interface_.reconfigured()) return;
  archive_matrix(a, implicit_operator_);
  if (a.reading()) factorise();
}

Eigen::VectorXd GravouilCombescure::free_velocity(Coupling& coupling, const Step& step) {
  Step trial = step;
  trial.absolute = trial.records = false;
  auto& implicit = *coupling.implicit_link();
  const std::vector<double> u = coupling.displacement();
  const Eigen::VectorXd guess = interface_.multiplier();
  std::vector<double> force = to_vector(guess);
  coupling.subtract_stiffness_force(force);
  // A trial: the coupling's own motion stays that of the last window.
  implicit.post_advance(trial, coupling.rows_of(implicit, force), Acceptance::trial);
  implicit.wait_advanced();
  std::vector<double> moved(u.size()), velocity(u.size());
  implicit.rows().scatter(implicit.output(), moved);
  implicit.rows().scatter(implicit.velocity_m_s(), velocity);
  const double stiffness = 2.0 / coupling.window_size_s();
  const Eigen::VectorXd multiplier = guess + stiffness * (interface_.impedance() * (view(moved) - view(u)));
  return view(velocity) + implicit_operator_ * multiplier;
}

void GravouilCombescure::step(Coupling& coupling, const Step& step) {
  Eigen::VectorXd begin, end;
  if (substeps_ > 1) {
    begin = view(coupling.velocity()) + implicit_operator_ * interface_.multiplier();
    end = free_velocity(coupling, step);
  }
  Step substep = step;
  substep.absolute = substep.records = false;
  substep.ends_window = false;
  for (int j = 1; j < substeps_; ++j) {
    substep.substep = j;
    interface_.advance_free(substep);
    const Eigen::VectorXd free = begin + (static_cast<double>(j) / substeps_) * (end - begin);
    const Eigen::VectorXd velocity = velocity_problem_.solve(free - implicit_operator_ * interface_.held());
    interface_.correct(substep, to_vector(velocity));
  }
  Step last = step;
  last.substep = substeps_;
  interface_.advance_free(last);
  coupling.advance_implicit(step, interface_.held_force(coupling));
  interface_.correct(last, coupling.velocity());
}

}  // namespace ricochet::coupler
