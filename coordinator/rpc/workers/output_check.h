// Checks that the files of a result are in the store.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/store/store.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// Returns an empty text if all `files` are in the store with the stated sizes, else the first
// problem: "ab/ab12.../.attempt-7/003/left.png: has 10 bytes, not 100". Lists each attempt's folder
// once, which an object store answers in one request for a thousand files. Files outside of
// attempts' folders are left to the queue's own check. Errors: those of Store::List.
absl::StatusOr<std::string> WhyNotInStore(const Store& store,
                                          const std::vector<JobKind::OutputFile>& files);

// Lists a folder as Store::List does.
using FolderLister =
    std::function<absl::StatusOr<std::vector<StoreEntry>>(const std::string& folder)>;
// As WhyNotInStore, with the lists of `list`. Errors: those of `list`.
absl::StatusOr<std::string> WhyNotListed(const FolderLister& list,
                                         const std::vector<JobKind::OutputFile>& files);

// Returns an empty text if one of `files`, which `draw` chooses, has the stated content, else what
// is wrong: workers write into a shared store by themselves, so that their hashes are hearsay until
// somebody reads the files. Reads no file of more than 64 MiB. Errors: those of the store.
absl::StatusOr<std::string> WhyNotAsHashed(const Store& store,
                                           const std::vector<JobKind::OutputFile>& files,
                                           uint64_t draw);

}  // namespace parallax
