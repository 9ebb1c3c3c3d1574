#pragma once

namespace parallax {

// Returns the number of cores that this process may run on, at least 1. It is less than the
// machine's under a scheduler that binds jobs to cores.
int UsableCores();

}  // namespace parallax
