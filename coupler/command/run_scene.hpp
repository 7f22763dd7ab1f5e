#pragma once

#include <optional>
#include <string>

#include "coupler/processes/given_scene.hpp"

namespace ricochet::coupler {

/// `ricochet run`: checks the scene, starts its participants, couples them to the end, writes the results into `out`
/// (empty: "out/<name of the scene file>") and prints the table; `with_error_bars`, or where the scene has a table
/// [accuracy], those below it. Whatever happens, no participant outlives this call and history.csv and summary.json are
/// there once the scene has been accepted. Throws ricochet::Error (its exit code says what kind) or Interrupted. A
/// changed scene is computed as `out`/scene/NAME.toml.
void run_scene(const GivenScene& given, const std::string& out, bool with_error_bars);

/// `ricochet resume`: goes on with the run in the folder `results` from its last whole checkpoint, to the end of its
/// scene or to `until_s`. `scene_path`: the scene, if the user names it; empty: as the checkpoint names it, which must
/// then be signed by this user's key. Throws as `run_scene`, and ConfigError if there is no checkpoint, the scene has
/// changed, or nobody but the folder names it.
void resume_run(const std::string& results, const std::string& scene_path, std::optional<double> until_s,
                std::optional<double> step_s);

/// `ricochet checkpoint`: has the run that writes into the folder `results` save all that it goes on from, and waits
/// until that is done. Throws ConfigError if no run is writing there, or it cannot.
void request_checkpoint(const std::string& results);

/// `ricochet check`: prints what the run would be, without starting a process. `picture_folder`: draws the scene into
/// scene.html there; empty: "out/<name of the scene file>_scene". Throws ConfigError.
void check_scene(const GivenScene& given, const std::optional<std::string>& picture_folder);

}  // namespace ricochet::coupler
