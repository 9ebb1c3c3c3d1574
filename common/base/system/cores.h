#pragma once

namespace parallax {

// Returns the number of cores that this process may use, at least 1: the ones it is bound to, or
// the quota of its control groups (a container's limit), rounded up, if that is less.
int UsableCores();

}  // namespace parallax
