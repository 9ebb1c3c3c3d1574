// A study's own receiver of notices, apart from what others may see of the study. Pure;
// thread-safe.
#pragma once

#include "parallax/v1/study.pb.h"

namespace parallax {

// Removes `notify` from a study, also its address from the study's text, and returns it. Without a
// receiver, the URL is empty.
v1::NotifySpec TakeNotify(v1::StudySpec* study);

}  // namespace parallax
