// What a study needs of a person before it can end well, for those that submit studies one after
// the other (streams, searches). Pure.
#pragma once

#include <string>
#include <string_view>

#include "parallax/v1/service.pb.h"

namespace parallax {

// Returns what a person must do before the study succeeds, with the command for it; empty if it has
// succeeded, or goes on by itself. `what` is the study's part: "chunk 3". `begin_again` is what
// helps if it was cancelled: "`parallax stream drive --close`, and begin it again".
std::string NeedsOf(const v1::StudyStatus& study, std::string_view what,
                    std::string_view begin_again);

}  // namespace parallax
