#include "coupler/study/study_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "common/base/error.hpp"
#include "coupler/study/study_case.hpp"

namespace ricochet::coupler {
namespace {

using scene::Override;

StudyCase computed(const std::string& what, const std::string& scene, const std::vector<Override>& changes,
                   const std::string& folder) {
  StudyCase run(scene, changes, folder);
  if (!run.failed() && run.repeats() == 0) {
    fmt::print("{}: computed in {}\n", what, run.folder());
    std::fflush(stdout);
    run.compute();
  } else if (!run.failed()) {
    fmt::print("{}: from {}\n", what, run.folder());
  }
  if (run.failed()) {
    throw Error(static_cast<ExitCode>(run.exit_code()), fmt::format("the {} failed: {}", what, run.error()));
  }
  return run;
}

std::string words_of(const std::vector<Override>& changes) {
  std::vector<std::string> words;
  for (const auto& change : changes) words.push_back(fmt::format("{} = {}", change.key, text_of(change)));
  return fmt::format("{}", fmt::join(words, ", "));
}

StudyReference computed_reference(const StudyFile& file, const std::vector<Override>& follows,
                                  const std::string& folder) {
  const auto& spec = file.reference;
  const auto changes = merged(follows, spec.changes);
  const auto run = computed("reference", file.scene, changes, folder);
  const auto refined = computed("reference, refined", file.scene, merged(changes, spec.refine), folder);
  StudyReference reference{follows, words_of(changes), run.key(), run.observation(), {}};
  const auto check = refined.observation();
  for (const auto& quantity : file.quantities) reference.errors.push_back(error_of(quantity, reference.seen, check));
  return reference;
}

StudyReference exact_reference(const StudyFile& file) {
  return {{},
          "impedance theory, exact",
          "exact",
          exact_impact(scene::build_problem(scene::load_scene(file.scene))),
          std::vector<std::optional<double>>(file.quantities.size(), 0.0)};
}

std::vector<Override> followed(const std::vector<std::string>& keys, const std::vector<Override>& settings) {
  std::vector<Override> result;
  for (const auto& setting : settings) {
    if (std::find(keys.begin(), keys.end(), setting.key) != keys.end()) result.push_back(setting);
  }
  return result;
}

bool same(const std::vector<Override>& a, const std::vector<Override>& b) { return words_of(a) == words_of(b); }

void print_errors(const StudyFile& file, const StudyReference& reference) {
  fmt::print("reference: {}\n", reference.text);
  for (std::size_t q = 0; q < file.quantities.size(); ++q) {
    const auto& error = reference.errors[q];
    fmt::print("  own error of {:<18} {}\n", file.quantities[q], error ? fmt::format("{:.3g}", *error) : "no value");
  }
}

}  // namespace

std::vector<StudyReference> find_references(const StudyFile& file, const std::string& folder) {
  std::vector<StudyReference> all;
  for (const auto& settings : all_combinations(file)) {
    const auto follows = followed(file.reference.follow, settings);
    const auto known = [&](const StudyReference& other) { return same(other.follows, follows); };
    if (std::any_of(all.begin(), all.end(), known)) continue;
    all.push_back(file.reference.exact ? exact_reference(file) : computed_reference(file, follows, folder));
    print_errors(file, all.back());
  }
  return all;
}

const StudyReference& reference_of(const std::vector<StudyReference>& references,
                                   const std::vector<Override>& settings) {
  return *std::find_if(references.begin(), references.end(), [&](const StudyReference& reference) {
    std::vector<std::string> keys;
    for (const auto& setting : reference.follows) keys.push_back(setting.key);
    return same(reference.follows, followed(keys, settings));
  });
}

}  // namespace ricochet::coupler
