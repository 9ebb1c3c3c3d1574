// A SQLite VFS that counts every operation that changes files, and at a chosen one ends the
// machine: as kill -9 does (what was written stays), or as a power cut does (of what was not
// synced, any part may be missing, in any order, torn at any sector). From then on, until the next
// plan, all operations fail.
//
// A power cut here: each 512-byte piece of each write since the file's last sync is kept or not by
// a coin, and one piece may be kept in part; a truncation likewise; a file made since may not
// exist. SQLite assumes no less of Debian's kernels ("powersafe overwrite").
#pragma once

#include <cstdint>

namespace parallax::faults {

// Errors of a disk that goes on. Operations that change files are counted from 1, with `reads` also
// those that read; `full`: only writes, which then say that the disk is full.
struct DiskErrors {
  int64_t at = -1;  // The first that fails; < 0: none.
  int64_t count = 1;
  bool full = false;
  bool reads = false;
};

struct VfsPlan {
  int64_t die_at = -1;         // The operation, from 1; < 0: none.
  bool lose_unsynced = false;  // Power cut instead of kill.
  uint64_t seed = 0;           // Decides which writes are lost.
  DiskErrors errors;
};

inline constexpr char kPowerCutVfs[] = "power-cut";

// Registers the VFS once, under kPowerCutVfs.
void RegisterPowerCutVfs();
// Sets the plan and restarts the count of operations. Call it before the queue opens.
void SetVfsPlan(const VfsPlan& plan);
// Ends the machine now. `lose_unsynced` must be that of the plan, or false.
void EndVfs(bool lose_unsynced);
bool VfsHasEnded();
// From now on the disk makes no errors.
void MendDisk();

}  // namespace parallax::faults
