#pragma once

#include <string>

#include "coupler/report/report.hpp"

namespace ricochet::report {

/// The charts of a page as files.
struct Pictures {
  std::string folder;  ///< "charts" beside the page
  int count = 0;
  std::string obstacle;  ///< why there are none, and what to do; else empty
};

/// Draws every chart of a page to charts/<id>.svg beside it, in place of what was drawn there before. Vega needs no
/// browser for that, but a JavaScript engine: `node`, from PATH. It is given the page as it was made here, programs and
/// all, never a file. Without it nothing is drawn and `obstacle` says so. Throws ConfigError if the folder cannot be
/// written or a picture there is not ours, and ParticipantError if the drawing program fails.
[[nodiscard]] Pictures draw_pictures(const Page& page);

}  // namespace ricochet::report
