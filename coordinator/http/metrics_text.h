// /metrics in Prometheus' text format, version 0.0.4.
#pragma once

#include <string>
#include <string_view>

#include "coordinator/http/status_snapshot.h"

namespace parallax {

std::string MetricsText(const StatusSnapshot& snapshot);

// With backslash, quote and newline escaped, for use between quotes.
std::string EscapeLabel(std::string_view value);

}  // namespace parallax
