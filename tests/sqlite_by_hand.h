// For tests that change a coordinator's database behind its back.
#pragma once

#include <sqlite3.h>

#include <string>

namespace parallax {

// Opens a database; null if that fails. Close it with sqlite3_close. Changes stay in its log: pages
// of the file have checksums, which SQLite by itself does not write.
inline sqlite3* OpenByHand(const std::string& path) {
  sqlite3* db = nullptr;
  if (sqlite3_open(path.c_str(), &db) != SQLITE_OK) return nullptr;
  sqlite3_db_config(db, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  return db;
}

}  // namespace parallax
