// Inner part of common/config: collects the errors in the files of one load, each with its place.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/config/check/checks.h"

namespace parallax::config_internal {

// The place of a value: file, line (from 1; 0: the file as a whole), and path of fields in that
// file.
struct Origin {
  std::string file;
  int line = 0;
  std::string path;
};

// Maps paths in a message to the origins of the values there. A value without an origin of its own
// has that of the nearest value around it.
class Origins {
 public:
  void Set(const std::string& path, Origin origin) { by_path_[path] = std::move(origin); }
  // Adds all of `other` as origins of values below `path`.
  void SetBelow(const std::string& path, const Origins& other);
  // Removes the origins of the item `index` of the list at `path`; later items move up.
  void EraseItem(const std::string& path, int index);
  // Returns the origin of the value at `path`; nothing if neither it nor any value around it has
  // one. Sets `own` to whether the value has an origin of its own.
  std::optional<Origin> Find(const std::string& path, bool* own) const;

 private:
  std::map<std::string, Origin> by_path_;
};

// The errors of one load. Not thread-safe.
class ConfigErrors {
 public:
  // Adds one error, unless the same is there. `what` says what was seen and what is allowed. An
  // origin without a file stands for a value that is in none: its text begins with the path.
  void Add(const Origin& origin, std::string_view what);
  // Adds the findings of checks in a message that was read from `file` and the files that it names.
  // A value that the reader has already reported is not reported again.
  void AddFindings(const Findings& findings, const Origins& origins, const std::string& file);
  // Takes the value at `origin` as reported, so that no finding on it is added: an error below it
  // says why it is incomplete.
  void SetTold(const Origin& origin) { told_.emplace(IndexOf(origin.file), origin.path); }
  bool empty() const { return errors_.empty(); }
  size_t size() const { return errors_.size(); }
  // Returns whether there are so many errors that the search for more can end.
  bool enough() const { return errors_.size() >= 100; }
  // Returns OK if there are no errors. Errors: kInvalidArgument with at most 20 lines "file:line:
  // path: what", sorted by file and line.
  absl::Status ToStatus() const;

 private:
  bool WasTold(const Origin& origin) const;
  // Returns the file's place in files_, where it is added if it is new.
  size_t IndexOf(const std::string& file);
  struct Error {
    size_t file;  // Index in files_.
    int line;
    std::string text;
  };
  std::vector<std::string> files_;  // In order of appearance.
  std::vector<Error> errors_;
  std::set<std::pair<size_t, std::string>> told_;  // File and path.
  std::set<std::string> texts_;
  int dropped_ = 0;
};

// Makes a status of findings without files. Errors: kInvalidArgument with lines "path: what".
absl::Status ToStatus(const Findings& findings);

}  // namespace parallax::config_internal
