// The lines of index.jsonl.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// (scene, rig): the order of the lines.
using FrameId = std::pair<uint32_t, uint32_t>;

// One frame of one variant, as its line in the index describes it.
struct IndexLine {
  FrameId key;
  std::string text;                          // The line, without its end.
  std::map<std::string, std::string> files;  // SHA-256 by name.
};

// Returns the content of index.jsonl: each line with its line end.
std::string IndexText(const std::vector<IndexLine>& index);

// Returns a frame's folder relative to the variant's: "frames/000012/003".
std::string FramePath(const FrameId& key);

// Makes the line, with the verdicts of `filters`. Errors: those of Judge.
absl::StatusOr<IndexLine> MakeIndexLine(const v1::PublishedFrame& frame,
                                        const v1::FilterConfig& filters);

// Replaces the line's verdicts by those of `filters`, from the statistics in the line. Errors:
// those of Judge; kDataLoss for a malformed line.
absl::Status JudgeAnew(const v1::FilterConfig& filters, IndexLine& line);

// Sets the line's statistic `ambiguous_share`, in [0, 1], or removes it, and judges the line anew.
// Errors: those of JudgeAnew.
absl::Status SetAmbiguousShare(std::optional<double> share, const v1::FilterConfig& filters,
                               IndexLine& line);
// Returns nothing for a frame that was not curated. Requires a line of ParseIndexLine or
// MakeIndexLine.
std::optional<double> AmbiguousShareOf(const IndexLine& line);

// Errors: kDataLoss for a malformed line.
absl::StatusOr<IndexLine> ParseIndexLine(const std::string& text);

}  // namespace parallax
