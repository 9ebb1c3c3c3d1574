// A base for SQLite VFSs that stand over another one: each operation goes on to the VFS below,
// except those that the upper one replaces.
//
// Files have version 2 of the methods: reads through a memory map, which version 3 has, would pass
// the upper VFS by.
#pragma once

#include <sqlite3.h>

#include <cstddef>

namespace parallax {

// The begin of each file of the upper VFS. The file below lies behind the upper one's.
struct ShimFile {
  sqlite3_file base;
  sqlite3_file* below;
};

inline sqlite3_file* FileBelow(sqlite3_file* file) {
  return reinterpret_cast<ShimFile*>(file)->below;
}
inline sqlite3_vfs* VfsBelow(sqlite3_vfs* vfs) { return static_cast<sqlite3_vfs*>(vfs->pAppData); }

template <auto Method, typename Result, typename... Args>
Result PassFile(sqlite3_file* file, Args... args) {
  return (FileBelow(file)->pMethods->*Method)(FileBelow(file), args...);
}
template <auto Method, typename... Args>
int PassVfs(sqlite3_vfs* vfs, Args... args) {
  return (VfsBelow(vfs)->*Method)(VfsBelow(vfs), args...);
}

// Returns methods that all go on to the file below.
constexpr sqlite3_io_methods PassingMethods() {
  using Methods = sqlite3_io_methods;
  Methods methods{};
  methods.iVersion = 2;
  methods.xClose = PassFile<&Methods::xClose>;
  methods.xRead = PassFile<&Methods::xRead>;
  methods.xWrite = PassFile<&Methods::xWrite>;
  methods.xTruncate = PassFile<&Methods::xTruncate>;
  methods.xSync = PassFile<&Methods::xSync>;
  methods.xFileSize = PassFile<&Methods::xFileSize>;
  methods.xLock = PassFile<&Methods::xLock>;
  methods.xUnlock = PassFile<&Methods::xUnlock>;
  methods.xCheckReservedLock = PassFile<&Methods::xCheckReservedLock>;
  methods.xFileControl = PassFile<&Methods::xFileControl>;
  methods.xSectorSize = PassFile<&Methods::xSectorSize>;
  methods.xDeviceCharacteristics = PassFile<&Methods::xDeviceCharacteristics>;
  methods.xShmMap = PassFile<&Methods::xShmMap>;
  methods.xShmLock = PassFile<&Methods::xShmLock>;
  methods.xShmBarrier = PassFile<&Methods::xShmBarrier>;
  methods.xShmUnmap = PassFile<&Methods::xShmUnmap>;
  return methods;
}

// Returns a VFS over `below`, to be registered. `File`, which begins with a ShimFile, is the type
// of its files; its `open` begins with OpenBelow. `name` must outlive the VFS.
template <typename File>
sqlite3_vfs VfsOver(sqlite3_vfs* below, const char* name, decltype(sqlite3_vfs::xOpen) open) {
  sqlite3_vfs vfs = *below;
  vfs.szOsFile = static_cast<int>(sizeof(File)) + below->szOsFile;
  vfs.pNext = nullptr;
  vfs.zName = name;
  vfs.pAppData = below;
  vfs.xOpen = open;
  vfs.xDelete = PassVfs<&sqlite3_vfs::xDelete>;
  vfs.xAccess = PassVfs<&sqlite3_vfs::xAccess>;
  vfs.xFullPathname = PassVfs<&sqlite3_vfs::xFullPathname>;
  return vfs;
}

// Opens the file below `file`, which has `methods` from then on.
template <typename File>
int OpenBelow(sqlite3_vfs* vfs, const sqlite3_io_methods& methods, sqlite3_filename name,
              sqlite3_file* file, int flags, int* out_flags) {
  ShimFile* shim = reinterpret_cast<ShimFile*>(file);
  shim->base.pMethods = nullptr;
  shim->below = reinterpret_cast<sqlite3_file*>(reinterpret_cast<File*>(file) + 1);
  const int code = PassVfs<&sqlite3_vfs::xOpen>(vfs, name, shim->below, flags, out_flags);
  // SQLite closes a file that has methods, even after an error.
  if (shim->below->pMethods != nullptr) shim->base.pMethods = &methods;
  return code;
}

}  // namespace parallax
