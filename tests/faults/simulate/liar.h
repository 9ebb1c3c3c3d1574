// A disk that lies: while the coordinator is down, somebody or something changes the files of its
// database. What was there is kept, to be put back.
#pragma once

#include <string>

#include "common/base/rng.h"
#include "tests/faults/simulate/knobs.h"

namespace parallax::faults {

class DatabaseLiar {
 public:
  // `folder` has the database, "queue.db".
  explicit DatabaseLiar(std::string folder) : folder_(std::move(folder)) {}

  // Where Lie::kOlder finds the backup.
  std::string backup_path() const { return folder_ + "/backup.db"; }
  bool has_lied() const { return lied_; }
  // Changes the files. Returns what was done, in words. `unix_s`: the time there.
  std::string Tell(Lie lie, Rng& dice, double unix_s);
  void PutBack();

 private:
  void RemoveDatabase();

  const std::string folder_;
  bool lied_ = false;
};

}  // namespace parallax::faults
