// A checksum in each page of a database, so that a disk that changes a page is found when the page
// is read, instead of being believed.
//
// The last 8 bytes of a page, which SQLite leaves alone, have the checksum of the others and of the
// page's place. It is written with the page and compared at each read from the database's file.
// (The log has SQLite's own checksums.) Databases that were made without such bytes have none.
//
// A program that writes a page without this VFS, as `sqlite3` does, leaves a wrong checksum.
#pragma once

#include <string>

struct sqlite3;

namespace parallax {

// The meaning of SQLITE_IOERR_DATA, for people.
inline constexpr char kWrongPage[] =
    "a page is not as it was written: the disk, or a program that is none of ours, has changed it; "
    "put a backup back";

// Returns the name of the VFS that does so over the VFS named `base` (empty: the system's), and
// registers it if it is new. Reading a wrong page is SQLITE_IOERR_DATA. Thread-safe.
std::string ChecksumVfs(const std::string& base);
// Makes room for checksums in the pages of a database that has no pages yet; changes no other
// database. The connection must have been opened through such a VFS.
void ReserveChecksums(sqlite3* db);
// The same: returns whether the database's pages have checksums.
bool HasChecksums(sqlite3* db);

}  // namespace parallax
