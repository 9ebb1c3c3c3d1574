#include "common/base/system/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <utility>

namespace parallax {

absl::StatusOr<TemporaryFolder> TemporaryFolder::Make(const std::string& name) {
  std::error_code error;
  std::string path = std::filesystem::temp_directory_path(error) / ("parallax-" + name + "-XXXXXX");
  if (error) return ErrnoError(error.value(), "find a folder for temporary files");
  if (mkdtemp(path.data()) == nullptr) return ErrnoError(errno, "make " + path);
  return TemporaryFolder(std::move(path));
}

TemporaryFolder::TemporaryFolder(std::string path) : path_(std::move(path)) {}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, "")) {}

TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&& other) noexcept {
  std::swap(path_, other.path_);
  return *this;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace parallax
