// The users' content in the store (common/store/content.h): bounds its size and removes what no
// study names any more.
//
// Content that a client has just put, or found there, belongs to no study until the client submits.
// So content stays for a day after the last Note() of it, or after it was first seen without a
// study; a coordinator that was restarted waits a day again.
//
// Thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/status.h"

namespace parallax {

class Store;

struct ContentOptions {
  int64_t most_bytes = int64_t{64} << 30;  // Of all users.
  double keep_s = 86'400;                  // Without a study.
  Clock* clock = &Clock::System();
};

class ContentKeeper {
 public:
  // `store` must outlive the keeper.
  explicit ContentKeeper(Store& store, const ContentOptions& options = {})
      : store_(store), options_(options) {}

  // Notes that somebody is about to use the file with this hash.
  void Note(const std::string& sha256);
  // Reserves bytes until GiveRoomBack returns them. Errors: kResourceExhausted when that is more
  // than is allowed; those of the store.
  absl::Status TakeRoom(int64_t bytes);
  void GiveRoomBack(int64_t bytes);

  // Removes the files that none of the lists with these hashes names, and those lists that are not
  // among them, once they are old enough. Removes nothing if one of `lists` can't be read. Returns
  // the number of removed files. Errors: those of the store; kInvalidArgument for a broken list.
  absl::StatusOr<int> Sweep(const std::vector<std::string>& lists);

 private:
  Store& store_;
  const ContentOptions options_;

  std::mutex mu_;
  int64_t bytes_ = -1;  // In the store or on the way; -1: not counted yet. Guarded, as below.
  std::map<std::string, SteadyTime> unused_since_;  // By hash.
};

}  // namespace parallax
