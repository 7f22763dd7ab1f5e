#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "coupler/interface/link.hpp"

namespace ricochet::coupler {

/// Which part of the answer to a trial window is looked at.
enum class Response { output, velocity };

/// Text of what is allowed in place of a participant that does not answer linearly, for error texts.
[[nodiscard]] std::string linear_bodies_are_needed(bool implicit);

/// A participant's answer to a trial window with that link input [N, m/s]. Needs the capability "repeat_window".
[[nodiscard]] Eigen::VectorXd trial_answer(Link& link, Response response, const Step& step,
                                           const std::vector<double>& input);

/// How the answer of a participant at the end of a window depends on its link input: column j is the change of the
/// answer per unit of link input j, by one trial window each, or for
/// many at once (probe_groups.hpp); as wide as the link. `probes`: the change that
/// is tried, per input, large enough to stand out of the rounding of the answer itself. Needs the capability
/// "repeat_window" and a synchronised link; leaves a trial behind, so synchronise again. Throws ConfigError naming the
/// participant if a trial again of the first input, or of all inputs at once with another size and sign, gives another
/// answer than the matrix does, or if that is not symmetric: it would not be that of a linear, conservative solver.
[[nodiscard]] Eigen::MatrixXd unit_response(Link& link, Response response, const Step& step,
                                            const std::vector<double>& probes);

}  // namespace ricochet::coupler
