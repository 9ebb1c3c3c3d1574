// The users' content in the store (common/store/content.h): bounds its size and removes what no
// study names any more.
//
// Content that a client has just put, or found there, belongs to no study until the client submits.
// So a file stays for `keep_s` after a sweep first finds it without a study; Note() makes the next
// sweep count anew, and so does a restart of the coordinator.
//
// Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

class Store;

struct ContentOptions {
  int64_t most_bytes = int64_t{64} << 30;  // Bound on the content of all users together.
  double keep_s = 86'400;                  // Time for which content without a study stays.
  Clock* clock = &Clock::System();
};

class ContentKeeper {
 public:
  // `store` must outlive the keeper.
  explicit ContentKeeper(Store& store, const ContentOptions& options = {})
      : store_(store), options_(options) {}

  // Notes that somebody is about to use the file with this hash.
  void Note(const std::string& sha256);
  // Checks that the lists that `study` names are in the store, and keeps them and their files until
  // the study is in the queue. The store is asked once about each list, and not about the files
  // that it names. `study` is not changed. Errors: kFailedPrecondition naming the variant and the
  // folder; those of the store.
  absl::Status CheckStudy(v1::StudySpec& study);
  // Reserves bytes until GiveRoomBack returns them. Errors: kResourceExhausted when that is more
  // than is allowed; those of the store.
  absl::Status TakeRoom(int64_t bytes);
  void GiveRoomBack(int64_t bytes);

  // Removes the content that no study needs and that has stayed long enough. Studies need the lists
  // with the hashes `lists` and the files that these lists name. A list that is missing or broken
  // keeps no files: nobody can read its folder any more. Returns the number of removed files.
  // Errors: those of the store.
  absl::StatusOr<int> Sweep(const std::vector<std::string>& lists);

 private:
  // Returns the lists that studies named that were submitted a short time ago.
  std::set<std::string> ListsOfSubmits();

  Store& store_;
  const ContentOptions options_;

  std::mutex mu_;
  // Size of the content in the store or on its way there; -1: not counted yet. mu_ guards it.
  int64_t bytes_ = -1;
  // When a sweep first found each file without a study, by the file's hash. mu_ guards it.
  std::map<std::string, SteadyTime> unused_since_;
  // When CheckStudy last found a study to name each list, by the list's hash. mu_ guards it.
  std::map<std::string, SteadyTime> submitted_;
};

}  // namespace parallax
