// Inner part of common/config: finds the text of a config, in a file or among the built-in ones.
// Thread-safe; reads files.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/config/builtin.h"

namespace parallax::config_internal {

struct ConfigText {
  std::string file;  // For messages: the path, or "builtin:studies/table1.yaml".
  std::string text;
};

// Returns the built-in file of this name ("studies/table1.yaml"); null if none exists.
const BuiltinFile* FindBuiltin(std::string_view name);
// Returns the names of the built-in files in `folder` ("studies/"), without ending, sorted.
std::vector<std::string> BuiltinNames(std::string_view folder);

// Reads the file at `path` or, if none exists, the built-in `folder`/`path`.yaml. Errors:
// kNotFound with the name that was probably meant, of a file beside it or of a built-in one, and
// all built-in names; those of ReadFile.
absl::StatusOr<ConfigText> ReadConfigText(const std::string& path, const std::string& folder);

// Reads what the file `from` names: a path relative to that file, or a built-in name. A built-in
// file names others as they lie in configs/ ("../scenes/indoor.yaml"); where no such file lies
// beside a copy of it, the built-in one is meant. Errors: those of ReadConfigText.
absl::StatusOr<ConfigText> ReadNamedText(const std::string& named, const std::string& from,
                                         const std::string& folder);

// Returns the path below "/" of a folder or file of the user's own content that the file `from`
// names. A path counts from the folder of `from`. If nothing is there, a plain relative path is
// returned as it is: it may lie below the root of a worker. Texts of built-in files, references to
// a store ("store:...") and empty texts are returned as they are.
std::string OwnPathOf(const std::string& named, const std::string& from);

}  // namespace parallax::config_internal
