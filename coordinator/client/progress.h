// Rates, times to completion and bars as text. Pure.
#pragma once

#include <optional>
#include <string>

#include "coordinator/client/terminal.h"

namespace parallax::client {

// `columns` wide: the part done, the part begun (dim), the rest. Fractions are clamped to [0, 1] in
// total.
std::string ProgressBar(const Terminal& terminal, double done, double begun, int columns);

// "412 pairs/h", "-" without a rate.
std::string FormatRate(std::optional<double> per_second);
// "ETA 1:05", "" without one.
std::string FormatEta(std::optional<double> seconds);
// 0..100 without decimals; 100 only when all is done. "-" when nothing is wanted.
std::string FormatPercent(double done, double wanted);

}  // namespace parallax::client
