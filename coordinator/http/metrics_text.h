// Writes /metrics in Prometheus' text format, version 0.0.4. Pure functions; thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "coordinator/http/status_snapshot.h"

namespace parallax {

// Returns the text of /metrics for a snapshot.
std::string MetricsText(const StatusSnapshot& snapshot);

// Returns `value` with backslash, quote and newline escaped, to be put between quotes.
std::string EscapeLabel(std::string_view value);

}  // namespace parallax
