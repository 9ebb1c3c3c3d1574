// Finds the files of a benchmark below the user's folder. Reads only.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/evaluate/benchmark.h"

namespace parallax {

// Returns the first of `candidates` that is a folder below `dir`, as an absolute path. Errors:
// kNotFound naming `dir` and all candidates.
absl::StatusOr<std::string> FindFolder(const std::string& dir,
                                       const std::vector<std::string>& candidates);

// Returns the names of the folders in `dir`, sorted; those that begin with a dot, and
// __MACOSX, are left out.
std::vector<std::string> SubFolders(const std::string& dir);
// Returns the names of the files in `dir` that end with the given ending, sorted; those
// that begin with a dot are left out.
std::vector<std::string> FilesEnding(const std::string& dir, const std::string& ending);

bool IsFile(const std::string& path);

// Returns a name of a pair with '_' for each character, such as a space, that a predictor's list of
// files can't hold.
std::string PlainName(std::string name);

// Returns the sets of pairs by their names: what comes before the first '_' ("mb2006_rocks1").
// Empty strings if that makes one set of all, or no set of two.
std::vector<std::string> GroupsByName(const std::vector<std::string>& names);

// Errors: kNotFound naming the first file of `paths` that is not there, and how many more aren't.
absl::Status RequireFiles(const std::vector<std::string>& paths);

// Middlebury's files. `mask` (mask0nocc.png) and `right` (disp1.pfm, from which a mask is made) may
// be empty.
struct MiddleburyFiles {
  std::string left, right, mask;
};
// Reads the truth of these files. The region "nocc" is there if a mask or the right truth is given.
// Errors: kInvalidArgument for maps of different sizes; as ReadTruth.
absl::StatusOr<PairTruth> ReadMiddleburyTruth(const MiddleburyFiles& files);

}  // namespace parallax
