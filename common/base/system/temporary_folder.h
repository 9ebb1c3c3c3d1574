// A folder for temporary files that is removed with the object that made it.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

class TemporaryFolder {
 public:
  // Makes "parallax-NAME-XXXXXX" in the system's folder for temporary files ($TMPDIR, else /tmp).
  // Errors: the system's (kPermissionDenied, kResourceExhausted, ...).
  static absl::StatusOr<TemporaryFolder> Make(const std::string& name);
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
  // Removes the folder with all that is in it.
  ~TemporaryFolder();

  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path);
  std::string path_;
};

}  // namespace parallax
