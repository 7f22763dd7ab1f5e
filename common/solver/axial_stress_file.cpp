#include "common/solver/axial_stress_file.hpp"

#include <fmt/format.h>

#include <cerrno>

#include "common/base/error.hpp"

namespace ricochet::solver {

AxialStressFile::AxialStressFile(const scene::Problem& problem, const std::string& participant,
                                 const participant::Setup& setup, const std::vector<BodyState>& states)
    : every_(problem.scene.output.axial_stress_every), window_size_s_(setup.window_size_s) {
  if (every_ == 0) return;
  path_ = fmt::format("{}/{}.axial_stress", setup.output_directory, participant);
  file_.open(path_);
  if (!file_) throw_errno(errno, "cannot write " + path_);
  line_ = "time_s";
  for (const auto& state : states) line_ += add_body(problem, state);
  add(0, states);
}

/// Returns the names of its columns.
std::string AxialStressFile::add_body(const scene::Problem& problem, const BodyState& state) {
  const auto& body = problem.bodies[static_cast<std::size_t>(state.body)];
  const auto layers = fem::axial_layers(body.mesh, body.section, most_layers);
  const auto volume = fem::volume_shares(state.part, layers);
  const fem::SparseMatrix all = fem::axial_stress_shares(state.part, layers);
  std::string names;
  std::vector<int> own;
  for (int layer = 0; layer < layers.size(); ++layer) {
    const auto i = static_cast<std::size_t>(layer);
    if (volume[i] == 0.0) continue;
    own.push_back(layer);
    names += fmt::format(",{}/{:.9g}/{:.9g}/{:.9g}", body.name, layers.border[i], layers.border[i + 1], volume[i]);
  }
  fem::SparseMatrix shares(static_cast<Eigen::Index>(own.size()), all.cols());
  for (std::size_t row = 0; row < own.size(); ++row) {
    shares.startVec(static_cast<Eigen::Index>(row));
    for (fem::SparseMatrix::InnerIterator it(all, own[row]); it; ++it) {
      shares.insertBack(static_cast<Eigen::Index>(row), it.col()) = it.value();
    }
  }
  shares.finalize();
  bodies_.push_back({shares, {}});
  return names;
}

void AxialStressFile::add(std::int64_t window, const std::vector<BodyState>& states) {
  if (every_ == 0 || window % every_ != 0) return;
  auto out = std::back_inserter(line_);
  out = fmt::format_to(out, "{}{:.17g}", window == 0 ? "\n" : "", static_cast<double>(window) * window_size_s_);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    auto& body = bodies_[b];
    body.stress.noalias() = body.shares * states[b].u;
    for (const double stress : body.stress) out = fmt::format_to(out, ",{:.6g}", stress);
  }
  line_ += '\n';
  errno = 0;
  file_ << line_;
  line_.clear();
  if (!file_) throw_errno(errno != 0 ? errno : EIO, "cannot write " + path_);
}

}  // namespace ricochet::solver
