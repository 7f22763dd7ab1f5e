#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Change of a participant's answer with a change of its link input, both in own rows.
using ChangeOfAnswer = std::function<Eigen::VectorXd(const Eigen::VectorXd& change)>;

/// The matrix of `unit_response` where a push reaches few nodes, as it does in a few explicit steps: nodes whose
/// answers do not overlap are pushed at once, and what moves belongs to the nearest of them (Curtis, Powell, Reid
/// 1974), so that the number of trials does not grow with that of the nodes. How far a push reaches is measured at a
/// few nodes, those that lie furthest from others among them. None where one trial for each input is no more, and where
/// the answers contradict the reach: something moves between the nodes that were pushed, or the matrix is not
/// symmetric.
[[nodiscard]] std::optional<Eigen::MatrixXd> response_by_groups(const Link& link, const std::vector<double>& probes,
                                                                const ChangeOfAnswer& answer);

}  // namespace ricochet::coupler
