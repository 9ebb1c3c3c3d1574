// Exit statuses of the program `coordinator`. They are part of the interface: never change a
// number.
#pragma once

namespace parallax {

enum CoordinatorExit : int {
  kExitOk = 0,
  kExitFailed = 1,
  kExitUsage = 2,
  kExitAddressInUse = 3,
  kExitNewerDatabase = 4,
  kExitDatabaseLocked = 5,
  kExitStoreUnwritable = 6,
  kExitDatabaseUnwritable = 7,
  kExitDatabaseDamaged = 8,  // Not a database, corrupt, or `check` found a broken invariant.
};

inline constexpr char kExitHelp[] = R"(Exit status:
  0  stopped on request, check passed, backup made
  1  another error                       2  bad arguments
  3  an address is in use                4  the database is of a newer version
  5  another coordinator has the database open
  6  the store can't be written          7  the database can't be written
  8  the database is damaged, or a check failed
 70  a commit failed while serving; start again after mending the disk)";

}  // namespace parallax
