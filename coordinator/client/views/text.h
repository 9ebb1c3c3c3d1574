// Formats numbers and names for people. Pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace parallax::client {

// Formats a duration: "7 s", "1:05", "2:03:04", "3 d 4 h"; "0.4 s" below ten seconds. Returns "-"
// for a negative or not finite one.
std::string FormatDuration(double seconds);
// Formats a duration that is only estimated, rounded so that nobody takes it for exact: "about
// 40 s", "about 4 min", "about 35 min", "about 1.5 h", "about 11 h", "about 3 d". Returns "-" for a
// negative or not finite one.
std::string FormatAbout(double seconds);
// Formats a size: "950 B", "1.2 kB", "34 MB".
std::string FormatBytes(double bytes);
// Formats a count: "12,345".
std::string FormatCount(int64_t count);
// Formats a number with three significant digits, and with an exponent from 1e15 on and below 1e-6:
// "0.0123", "4.56", "1,234", "1e+19".
std::string FormatNumber(double value);
// Formats a count with its noun: "1 pair", "2 pairs".
std::string Plural(int64_t count, std::string_view singular, std::string_view plural = "");
// Formats a local time: "2024-05-01 13:37:00"; "-" for 0.
std::string FormatUnixTime(double unix_s);
// Returns a small chart of `values`, resampled to at most `columns` columns and scaled from the
// lowest to the highest value. "" without values.
std::string Sparkline(std::span<const double> values, int columns, bool unicode);
// Returns the first line of a message without trailing space: errors are shown as one line.
std::string FirstLine(std::string_view text);
// Returns the lines of `now`, the end of a log, that its earlier end `before` does not have. A line
// that was not whole comes again; "..." stands for lines between them that neither has.
std::vector<std::string> NewLines(std::string_view before, std::string_view now);
// Returns why `text` is no seed, in the words of a study file's `seed`; "" if it is one.
std::string WhyNotSeed(const std::string& text);
// Returns the name of an enumerator in lower case without its prefix: "SUCCEEDED" -> "succeeded";
// "STUDY_STATE_RUNNING" with prefix "STUDY_STATE_" -> "running".
std::string LowerName(std::string_view name, std::string_view prefix = "");

}  // namespace parallax::client
