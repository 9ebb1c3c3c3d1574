// Brings the folders of own content that a study names into a coordinator's store, so that workers
// need no copy of their own.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "common/store/store.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

struct ShippedContent {
  int64_t folders = 0;
  int64_t files = 0;  // In all folders, whether they were in the store before or not.
  int64_t bytes = 0;
};

// Puts the files of each folder, and its list, into `store` (common/store/content.h), and makes the
// study name the lists in place of the folders. A folder that this machine does not have stays as
// it is, because the workers may have it. Files that the store already has are not sent again.
// Errors: kInvalidArgument for a file name that a list can't hold, or for more files or bytes than
// are allowed; those of reading files and of the store, naming the folder.
absl::StatusOr<ShippedContent> ShipContent(v1::StudySpec& study, Store& store);

// Makes the study name folders that lists in a store stand for by their paths below a worker's
// --picture-root: each worker takes its own copy.
void NameOwnCopies(v1::StudySpec& study);

}  // namespace parallax::client
