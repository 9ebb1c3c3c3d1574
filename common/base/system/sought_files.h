// Notes which files a piece of work reads, so that it can be done again when one of them changes.
#pragma once

#include <set>
#include <string>

namespace parallax {

// While it exists, notes the files that its thread reads by ReadFile (file.h), and those that
// NoteSought names, whether they are there or not. The innermost scope of a thread notes. Not
// thread-safe.
class SoughtFiles {
 public:
  SoughtFiles();
  ~SoughtFiles();
  SoughtFiles(const SoughtFiles&) = delete;
  SoughtFiles& operator=(const SoughtFiles&) = delete;

  // The paths as they were given.
  const std::set<std::string>& paths() const { return paths_; }

 private:
  friend void NoteSought(const std::string& path);
  std::set<std::string> paths_;
  SoughtFiles* const outer_;
};

// Notes that this thread looks for the file `path`. Does nothing without a SoughtFiles.
void NoteSought(const std::string& path);

}  // namespace parallax
