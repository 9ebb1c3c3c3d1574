// The disk with the store, which all simulated machines share. It is a real store in the run's
// folder: workers put the files of their results there, and somebody or something changes them.
#pragma once

#include <set>
#include <string>

#include "common/base/rng.h"
#include "coordinator/queue/job_queue.h"
#include "parallax/v1/service.pb.h"

namespace parallax::faults {

class SharedDisk {
 public:
  // The store is "store" in `folder`.
  explicit SharedDisk(const std::string& folder) : root_(folder + "/store") {}

  std::string uri() const { return "file://" + root_; }
  // Puts the files that a worker's report names, and enters their sizes and hashes in it. The store
  // must be there.
  void PutFiles(v1::CompleteRequest& report) const;
  // Flips a bit of a file of some result, or removes it or all files of its attempt. Returns what
  // was done, in words; empty if there is no file.
  std::string Lie(Rng& dice);
  // Returns whether a lie was about files in this folder of the store.
  bool HasLiedAbout(const std::string& folder) const;
  // Returns whether a file is on the disk with its size and content. Reads it without the store.
  bool Has(const JobKind::OutputFile& file) const;

 private:
  const std::string root_;
  std::set<std::string> lies_;  // Files and folders, in the store's paths.
};

}  // namespace parallax::faults
