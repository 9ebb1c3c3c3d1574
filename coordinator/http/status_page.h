// The status page: one HTML document without scripts or anything from elsewhere.
#pragma once

#include <string>
#include <string_view>

#include "coordinator/http/status_snapshot.h"

namespace parallax {

std::string StatusPage(const StatusSnapshot& snapshot);

// For text and attribute values.
std::string EscapeHtml(std::string_view text);
// "3 d 4 h", "12 min", "5 s"
std::string DurationText(double seconds);
// 1234567 -> "1 234 567" with thin spaces.
std::string CountText(int64_t count);

}  // namespace parallax
