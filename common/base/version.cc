#include "common/base/version.h"

namespace parallax {

// The build gives the version to this file alone, so that a new one compiles nothing else again.
const char* const kProgramVersion = PARALLAX_VERSION;

}  // namespace parallax
