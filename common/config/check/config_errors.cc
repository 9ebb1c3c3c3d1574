#include "common/config/check/config_errors.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "common/base/names.h"

namespace parallax::config_internal {
namespace {

constexpr size_t kMostLines = 20;
constexpr size_t kMostKept = 1000;

absl::Status StatusOf(const std::vector<std::string>& lines, size_t dropped) {
  if (lines.empty()) return absl::OkStatus();
  std::string message;
  for (size_t i = 0; i < std::min(lines.size(), kMostLines); ++i) {
    message += (i == 0 ? "" : "\n") + lines[i];
  }
  if (lines.size() > kMostLines) dropped += lines.size() - kMostLines;
  if (dropped > 0) message += fmt::format("\nand {} more", dropped);
  return InvalidArgument("{}", message);
}

}  // namespace

void Origins::SetBelow(const std::string& path, const Origins& other) {
  for (const auto& [below, origin] : other.by_path_) by_path_[path + "." + below] = origin;
}

void Origins::EraseItem(const std::string& path, int index) {
  std::map<std::string, Origin> kept;
  for (auto& [place, origin] : by_path_) {
    int item = 0;
    const char* const begin = place.data() + std::min(place.size(), path.size() + 1);
    const auto [end, error] = std::from_chars(begin, place.data() + place.size(), item);
    if (!place.starts_with(path + "[") || error != std::errc() || item < index) {
      kept[place] = std::move(origin);
    } else if (item > index) {
      kept[fmt::format("{}[{}{}", path, item - 1, end)] = std::move(origin);
    }
  }
  by_path_ = std::move(kept);
}

std::optional<Origin> Origins::Find(const std::string& path, bool* own) const {
  for (std::string around = path; !around.empty();) {
    const auto found = by_path_.find(around);
    if (found != by_path_.end()) {
      *own = around == path;
      return found->second;
    }
    const size_t end = around.find_last_of(".[");
    around.resize(end == std::string::npos ? 0 : end);
  }
  return std::nullopt;
}

void ConfigErrors::Add(const Origin& origin, std::string_view what) {
  if (errors_.size() == kMostKept) {
    ++dropped_;
    return;
  }
  const size_t file = IndexOf(origin.file);
  std::string text = origin.file;
  if (!text.empty() && origin.line > 0) text += fmt::format(":{}", origin.line);
  if (!text.empty()) text += ": ";
  // Keys of a file that are no field stand in a path as they came.
  if (!origin.path.empty()) text += Printable(origin.path) + ": ";
  told_.emplace(file, origin.path);
  text += what;
  // A tree that is merged into several messages has the same errors each time.
  if (texts_.insert(text).second) errors_.push_back({file, origin.line, std::move(text)});
}

size_t ConfigErrors::IndexOf(const std::string& file) {
  const auto known = std::find(files_.begin(), files_.end(), file);
  const auto index = static_cast<size_t>(known - files_.begin());
  if (known == files_.end()) files_.push_back(file);
  return index;
}

bool ConfigErrors::WasTold(const Origin& origin) const {
  const auto file = std::find(files_.begin(), files_.end(), origin.file);
  return told_.count({static_cast<size_t>(file - files_.begin()), origin.path}) > 0;
}

void ConfigErrors::AddFindings(const Findings& findings, const Origins& origins,
                               const std::string& file) {
  const bool read_well = empty();
  for (const Finding& finding : findings) {
    bool own = false;
    std::optional<Origin> origin = origins.Find(finding.path, &own);
    if (!origin) {
      // Not in the file at all: the reader told that it is missing.
      if (read_well) Add({file, 0, finding.path}, finding.what);
      continue;
    }
    // A value that could not be read is empty, and so is all that should be in it.
    if (WasTold(*origin)) continue;
    if (!own) {
      origin->path = finding.path;
      if (WasTold(*origin)) continue;
    }
    Add(*origin, finding.what);
  }
}

absl::Status ConfigErrors::ToStatus() const {
  std::vector<Error> sorted = errors_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Error& a, const Error& b) {
    return std::make_pair(a.file, a.line) < std::make_pair(b.file, b.line);
  });
  std::vector<std::string> lines;
  for (Error& error : sorted) lines.push_back(std::move(error.text));
  return StatusOf(lines, static_cast<size_t>(dropped_));
}

absl::Status ToStatus(const Findings& findings) {
  std::vector<std::string> lines;
  for (const Finding& finding : findings) {
    lines.push_back(finding.path.empty() ? finding.what : finding.path + ": " + finding.what);
  }
  return StatusOf(lines, 0);
}

}  // namespace parallax::config_internal
