#pragma once

namespace parallax {

// Cores that this process may run on, at least 1: fewer than the machine has under a scheduler that
// binds jobs to cores.
int UsableCores();

}  // namespace parallax
