#pragma once

#include <string>
#include <vector>

#include "coupler/results/history.hpp"
#include "coupler/watch/conserved.hpp"
#include "tests/support/one_process.hpp"

namespace ricochet::test {

inline coupler::History history_of(OneProcess& run) {
  std::vector<std::string> bodies;
  for (const auto& body : run.problem().bodies) bodies.push_back(body.name);
  std::vector<coupler::History::Source> sources;
  for (const auto& link : run.coupling().links()) sources.push_back({link.name(), link.description().record_columns});
  return coupler::History(sources, bodies, coupler::conserved_by(run.problem()), run.problem().scene.contact_names());
}

/// All rows of a scene computed in one process: what history.csv is written from, with the sums per body.
inline std::vector<coupler::HistoryRow> rows_of(const std::string& scene_path) {
  OneProcess run(scene_path);
  coupler::History history = history_of(run);
  std::vector<coupler::HistoryRow> rows;
  auto& links = run.coupling().links();
  const auto take_rows = [&](std::int64_t) {
    for (std::size_t p = 0; p < links.size(); ++p) history.add(p, links[p].take_records());
    while (auto row = history.next(run.problem().clock.size_s())) rows.push_back(*std::move(row));
  };
  run.run(take_rows);
  for (auto& link : links) {  // a run that ends early has rows left
    link.post_finish();
    link.wait_finished();
  }
  take_rows(0);
  return rows;
}

}  // namespace ricochet::test
