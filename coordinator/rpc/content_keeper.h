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
#include <optional>
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
  // Checks that the lists that `study` names are in the store and can be read, and that the files
  // that they name are there with their sizes; keeps all of them until the study is in the queue.
  // `study` is not changed. Errors: kFailedPrecondition naming the variant or
  // benchmark, the folder and the file
  // that is not there; kInvalidArgument for a broken list, naming its line; those of the store.
  absl::Status CheckStudy(v1::StudySpec& study);
  // Reserves room for a file that is on its way to the store. A file takes room once, however many
  // send it at the same time. Errors: kResourceExhausted when that is more than is allowed; those
  // of the store.
  absl::Status TakeRoom(const std::string& sha256, int64_t bytes);
  // Ends a reservation. The room is given back unless this or another sender has `stored` the file.
  void EndRoom(const std::string& sha256, bool stored);

  // Removes the content that no study needs and that has stayed long enough. Studies need the lists
  // with the hashes `lists` and the files that these lists name. A list that is missing or broken
  // keeps no files: nobody can read its folder any more. Returns the number of removed files.
  // Errors: those of the store.
  absl::StatusOr<int> Sweep(const std::vector<std::string>& lists);

 private:
  // Reads a list and checks that its files are there. `sizes` has the files of the store by hash;
  // it is read when it is first needed.
  absl::Status CheckList(const std::string& list,
                         std::optional<std::map<std::string, int64_t>>& sizes);
  // Checks the list that `name` refers to, if it does, unless its hash is among those `checked`.
  absl::Status CheckContent(const std::string& name, const std::string& user,
                            std::set<std::string>& checked,
                            std::optional<std::map<std::string, int64_t>>& sizes);
  // Returns the lists that studies named that were submitted a short time ago.
  std::set<std::string> ListsOfSubmits();

  Store& store_;
  const ContentOptions options_;

  std::mutex mu_;
  // Size of the content in the store or on its way there; -1: not counted yet. mu_ guards it.
  int64_t bytes_ = -1;
  // Files on their way, by hash. mu_ guards it.
  struct OnItsWay {
    int64_t bytes = 0;
    int senders = 0;
    bool stored = false;
  };
  std::map<std::string, OnItsWay> on_way_;
  // When a sweep first found each file without a study, by the file's hash. mu_ guards it.
  std::map<std::string, SteadyTime> unused_since_;
  // When CheckStudy last found a study to name each list, by the list's hash. mu_ guards it.
  std::map<std::string, SteadyTime> submitted_;
};

}  // namespace parallax
