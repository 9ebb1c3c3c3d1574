// Reads and writes whole files; errno becomes a status. For durable writes see
// common/store/store.h. Thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Returns the file's content. Errors: those of open(2) and read(2), naming the path;
// kResourceExhausted if it is larger than `max_bytes` or than the memory of this process allows.
absl::StatusOr<std::string> ReadFile(const std::string& path, size_t max_bytes = size_t{1} << 32);

// Creates the file or replaces its content. With `sync`, the data (not the folder's entry) is on
// disk when the call returns. A failed write leaves no file behind. Errors: those of open(2),
// write(2) and fsync(2), naming the path.
absl::Status WriteFile(const std::string& path, std::string_view bytes, bool sync = false);

struct DiskSpace {
  int64_t free_bytes = 0;  // For users who are not root.
  int64_t total_bytes = 0;
};
// Returns the space of the disk that `path` is on. Errors: those of statvfs(2), naming the path.
absl::StatusOr<DiskSpace> SpaceOfDisk(const std::string& path);

// Makes the folder `dir` of this machine, with its parents. Errors: those of mkdir(2).
absl::Status MakeFolders(const std::string& dir);

// Takes the places of a standard input, output or error that the program was started without
// (`>&-`): the next file or socket would be opened as it, and get what is printed. Writing there
// goes on to fail. Call it before anything is opened.
void HoldStandardStreams();

}  // namespace parallax
