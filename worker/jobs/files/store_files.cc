#include "worker/jobs/files/store_files.h"

#include <algorithm>

namespace parallax {

absl::StatusOr<std::string> GetWhole(const Store& store, const std::string& path, int64_t size) {
  constexpr int64_t kPiece = 4 << 20;
  std::string bytes;
  for (int64_t got = 0; got <= size; got = static_cast<int64_t>(bytes.size())) {
    // One byte more than there should be: a longer file is noticed.
    const auto most = static_cast<size_t>(std::min(kPiece, size + 1 - got));
    ASSIGN_OR_RETURN(const std::string piece, store.GetPiece(path, got, most));
    bytes += piece;
    const bool all_there = static_cast<int64_t>(bytes.size()) >= size;
    if (piece.empty() || (all_there && piece.size() < most)) break;
  }
  if (static_cast<int64_t>(bytes.size()) == size) return bytes;
  return DataLoss("{}: damaged: the store gives {} bytes of it where {} are expected", path,
                  bytes.size(), size);
}

}  // namespace parallax
