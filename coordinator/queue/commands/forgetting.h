// Forgets studies and moves old ones to the archive.
//
// A forgotten study is gone for everybody in the transaction that says so. Its rows go later, some
// at a time: first what refers to results, and with the last reference the result itself, whose
// files become litter in the same transaction; then its jobs. A result that another study's pairs,
// networks or scenes refer to stays, whoever made it.
//
// Used by the writing thread only.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/status.h"
#include "coordinator/queue/tables/queue_tables.h"

namespace parallax {

class Forgetting {
 public:
  // `tables` must outlive the object.
  explicit Forgetting(Tables& tables) : tables_(tables) {}

  // Forgets a study; see JobQueue. Errors: kNotFound; kFailedPrecondition if it has not ended.
  absl::StatusOr<v1::ForgetReply> Forget(int64_t study, std::string_view reason,
                                         std::string_view actor);
  // Removes up to `limit` rows of a forgotten study. Returns true if there may be more. Errors: the
  // database's.
  absl::StatusOr<bool> RemoveSome(int limit);
  // Moves up to `limit` jobs of a study that finished long ago to the archive. Returns true if
  // there may be more. Errors: the database's.
  absl::StatusOr<bool> Archive(int limit);

 private:
  Tables& tables_;
};

}  // namespace parallax
