// Formats rates, times to completion and bars as text. Pure functions.
#pragma once

#include <optional>
#include <string>

#include "coordinator/client/views/terminal.h"

namespace parallax::client {

// Returns a bar of `columns` columns: the part that is done, the part that has begun (dim), the
// rest. `done` and `begun` are fractions, whose sum is clamped to [0, 1].
std::string ProgressBar(const Terminal& terminal, double done, double begun, int columns);

// Returns "412 pairs/h"; "-" without a rate.
std::string FormatRate(std::optional<double> per_second);
// Returns "ETA 1:05"; "" without a time.
std::string FormatEta(std::optional<double> seconds);
// Returns 0..100 without decimals; 100 only if everything is done. "-" if nothing is wanted.
std::string FormatPercent(double done, double wanted);

}  // namespace parallax::client
