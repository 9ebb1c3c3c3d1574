// Inner part of common/config: what is wrong with the files of one load, each with its place.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/config/checks.h"

namespace parallax::config_internal {

// Where a value stands: file, line (from 1; 0 = the file as a whole), and its path in that file.
struct Origin {
  std::string file;
  int line = 0;
  std::string path;
};

// The origins of a message's values by their path in the message. A value that has none of its own
// has that of the nearest value around it.
class Origins {
 public:
  void Set(const std::string& path, Origin origin) { by_path_[path] = std::move(origin); }
  // All of `other`, as values below `path`.
  void SetBelow(const std::string& path, const Origins& other);
  // Nothing if neither the value nor one around it has an origin. `own`: the value has.
  std::optional<Origin> Find(const std::string& path, bool* own) const;

 private:
  std::map<std::string, Origin> by_path_;
};

class ConfigErrors {
 public:
  void Add(const Origin& origin, std::string_view what);
  // What the checks found in a message that was read from `file` and those it names. A value of
  // which the reader has told already is not told of twice.
  void AddFindings(const Findings& findings, const Origins& origins, const std::string& file);
  bool empty() const { return errors_.empty(); }
  // So many that looking for more is a waste.
  bool enough() const { return errors_.size() >= 100; }
  // By file and line, at most 20 lines "file:line: path: what".
  // Errors: kInvalidArgument with these lines; OK if there are none.
  absl::Status ToStatus() const;

 private:
  bool WasTold(const Origin& origin) const;
  struct Error {
    size_t file;  // Index in files_.
    int line;
    std::string text;
  };
  std::vector<std::string> files_;  // In order of appearance.
  std::vector<Error> errors_;
  std::set<std::pair<size_t, std::string>> told_;  // File and path.
  int dropped_ = 0;
};

// The same without files. Errors: kInvalidArgument with lines "path: what"; OK without findings.
absl::Status ToStatus(const Findings& findings);

}  // namespace parallax::config_internal
