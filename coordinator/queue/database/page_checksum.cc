#include "coordinator/queue/database/page_checksum.h"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace parallax {
namespace {

constexpr int kChecksumBytes = 8;
constexpr int kHeaderBytes = 100;  // What SQLite reads of a file to know it.
constexpr int kReservedAt = 20;    // In the header: the bytes at a page's end that it spares.
constexpr char kMagic[] = "SQLite format 3";
constexpr int kLeastPageBytes = 512;
constexpr int kMostPageBytes = 65536;

struct CheckedFile {
  sqlite3_file base;
  bool has_checksums;
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};
CheckedFile* Checked(sqlite3_file* file) { return reinterpret_cast<CheckedFile*>(file); }
sqlite3_file* Real(sqlite3_file* file) { return Checked(file)->real(); }
sqlite3_vfs* RealVfs(sqlite3_vfs* vfs) { return static_cast<sqlite3_vfs*>(vfs->pAppData); }

// Each step is one to one, so that one changed word changes the result.
uint64_t ChecksumOf(const char* page, int bytes, sqlite3_int64 offset) {
  uint64_t sum = static_cast<uint64_t>(offset) + 0x9e3779b97f4a7c15u;
  for (int at = 0; at < bytes - kChecksumBytes; at += 8) {
    uint64_t word;
    std::memcpy(&word, page + at, sizeof(word));
    sum = (sum ^ word) * 0xff51afd7ed558ccdu;
    sum ^= sum >> 32;
  }
  return sum;
}

uint64_t StoredIn(const char* page, int bytes) {
  uint64_t sum;
  std::memcpy(&sum, page + bytes - kChecksumBytes, sizeof(sum));
  return sum;
}

bool IsPage(int bytes, sqlite3_int64 offset) {
  return bytes >= kLeastPageBytes && bytes <= kMostPageBytes && (bytes & (bytes - 1)) == 0 &&
         offset % bytes == 0;
}

// A page that was never written has none.
bool IsEmpty(const char* page, int bytes) {
  return std::all_of(page, page + bytes, [](char byte) { return byte == 0; });
}

// Whether a first page that tells of no checksums has one: then that byte is what has changed.
bool HasLostItsMark(const char* page, int bytes) {
  if (page[kReservedAt] != 0) return false;
  std::vector<char> marked(page, page + bytes);
  marked[kReservedAt] = kChecksumBytes;
  return StoredIn(page, bytes) == ChecksumOf(marked.data(), bytes, 0);
}

int Read(sqlite3_file* file, void* bytes, int amount, sqlite3_int64 offset) {
  const int code = Real(file)->pMethods->xRead(Real(file), bytes, amount, offset);
  const char* page = static_cast<const char*>(bytes);
  if (code == SQLITE_OK && offset == 0 && amount >= kHeaderBytes) {
    Checked(file)->has_checksums =
        std::memcmp(page, kMagic, sizeof(kMagic)) == 0 && page[kReservedAt] != 0;
  }
  if (code != SQLITE_OK || !IsPage(amount, offset)) return code;
  const bool is_wrong =
      Checked(file)->has_checksums
          ? StoredIn(page, amount) != ChecksumOf(page, amount, offset) && !IsEmpty(page, amount)
          : offset == 0 && HasLostItsMark(page, amount);
  return is_wrong ? SQLITE_IOERR_DATA : SQLITE_OK;
}

int Write(sqlite3_file* file, const void* bytes, int amount, sqlite3_int64 offset) {
  const char* page = static_cast<const char*>(bytes);
  if (offset == 0 && amount >= kHeaderBytes) {
    Checked(file)->has_checksums = page[kReservedAt] == kChecksumBytes;
  }
  if (!Checked(file)->has_checksums || !IsPage(amount, offset)) {
    return Real(file)->pMethods->xWrite(Real(file), bytes, amount, offset);
  }
  // On the stack: the last pages are written when the process ends, after its threads' variables.
  std::array<char, kMostPageBytes> copy;
  std::memcpy(copy.data(), page, static_cast<size_t>(amount));
  const uint64_t sum = ChecksumOf(page, amount, offset);
  std::memcpy(copy.data() + amount - kChecksumBytes, &sum, sizeof(sum));
  return Real(file)->pMethods->xWrite(Real(file), copy.data(), amount, offset);
}

// ---- All else is the VFS's below
int Close(sqlite3_file* file) { return Real(file)->pMethods->xClose(Real(file)); }
int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  return Real(file)->pMethods->xTruncate(Real(file), size);
}
int Sync(sqlite3_file* file, int flags) { return Real(file)->pMethods->xSync(Real(file), flags); }
int FileSize(sqlite3_file* file, sqlite3_int64* size) {
  return Real(file)->pMethods->xFileSize(Real(file), size);
}
int Lock(sqlite3_file* file, int level) { return Real(file)->pMethods->xLock(Real(file), level); }
int Unlock(sqlite3_file* file, int level) {
  return Real(file)->pMethods->xUnlock(Real(file), level);
}
int CheckReservedLock(sqlite3_file* file, int* held) {
  return Real(file)->pMethods->xCheckReservedLock(Real(file), held);
}
int FileControl(sqlite3_file* file, int what, void* argument) {
  return Real(file)->pMethods->xFileControl(Real(file), what, argument);
}
int SectorSize(sqlite3_file* file) { return Real(file)->pMethods->xSectorSize(Real(file)); }
int DeviceCharacteristics(sqlite3_file* file) {
  return Real(file)->pMethods->xDeviceCharacteristics(Real(file));
}
int ShmMap(sqlite3_file* file, int page, int size, int extend, void volatile** memory) {
  return Real(file)->pMethods->xShmMap(Real(file), page, size, extend, memory);
}
int ShmLock(sqlite3_file* file, int offset, int n, int flags) {
  return Real(file)->pMethods->xShmLock(Real(file), offset, n, flags);
}
void ShmBarrier(sqlite3_file* file) { Real(file)->pMethods->xShmBarrier(Real(file)); }
int ShmUnmap(sqlite3_file* file, int remove) {
  return Real(file)->pMethods->xShmUnmap(Real(file), remove);
}

// Version 2: reads through a memory map, which version 3 has, would not be checked.
const sqlite3_io_methods kMethods = {2,
                                     Close,
                                     Read,
                                     Write,
                                     Truncate,
                                     Sync,
                                     FileSize,
                                     Lock,
                                     Unlock,
                                     CheckReservedLock,
                                     FileControl,
                                     SectorSize,
                                     DeviceCharacteristics,
                                     ShmMap,
                                     ShmLock,
                                     ShmBarrier,
                                     ShmUnmap,
                                     nullptr,
                                     nullptr};

int Open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  sqlite3_vfs* real = RealVfs(vfs);
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) return real->xOpen(real, name, file, flags, out_flags);
  CheckedFile* checked = Checked(file);
  checked->base.pMethods = nullptr;
  checked->has_checksums = false;
  const int code = real->xOpen(real, name, checked->real(), flags, out_flags);
  // SQLite closes a file that has methods, even after an error.
  if (checked->real()->pMethods != nullptr) checked->base.pMethods = &kMethods;
  return code;
}
int Delete(sqlite3_vfs* vfs, const char* name, int sync_folder) {
  return RealVfs(vfs)->xDelete(RealVfs(vfs), name, sync_folder);
}
int Access(sqlite3_vfs* vfs, const char* name, int flags, int* out) {
  return RealVfs(vfs)->xAccess(RealVfs(vfs), name, flags, out);
}
int FullPathname(sqlite3_vfs* vfs, const char* name, int size, char* out) {
  return RealVfs(vfs)->xFullPathname(RealVfs(vfs), name, size, out);
}

CheckedFile* FileOf(sqlite3* db) {
  sqlite3_file* file = nullptr;
  sqlite3_file_control(db, "main", SQLITE_FCNTL_FILE_POINTER, &file);
  return file != nullptr && file->pMethods == &kMethods ? Checked(file) : nullptr;
}

struct Registered {
  std::string name;
  sqlite3_vfs vfs{};
};

}  // namespace

std::string ChecksumVfs(const std::string& base) {
  static std::mutex mutex;
  static std::map<std::string, std::unique_ptr<Registered>> all;  // By `base`. Guarded by mutex.
  const std::lock_guard lock(mutex);
  std::unique_ptr<Registered>& known = all[base];
  if (known != nullptr) return known->name;
  sqlite3_vfs* real = sqlite3_vfs_find(base.empty() ? nullptr : base.c_str());
  if (real == nullptr) return base;  // Opening says so.
  known = std::make_unique<Registered>();
  known->name = "checksum" + (base.empty() ? "" : "-" + base);
  known->vfs = *real;
  known->vfs.szOsFile = static_cast<int>(sizeof(CheckedFile)) + real->szOsFile;
  known->vfs.pNext = nullptr;
  known->vfs.zName = known->name.c_str();
  known->vfs.pAppData = real;
  known->vfs.xOpen = Open;
  known->vfs.xDelete = Delete;
  known->vfs.xAccess = Access;
  known->vfs.xFullPathname = FullPathname;
  sqlite3_vfs_register(&known->vfs, 0);
  return known->name;
}

void ReserveChecksums(sqlite3* db) {
  CheckedFile* file = FileOf(db);
  sqlite3_int64 size = 0;
  if (file == nullptr || FileSize(&file->base, &size) != SQLITE_OK || size > 0) return;
  int bytes = kChecksumBytes;
  sqlite3_file_control(db, "main", SQLITE_FCNTL_RESERVE_BYTES, &bytes);
  file->has_checksums = true;  // Pages may be written before the first one, which tells of it.
}

bool HasChecksums(sqlite3* db) {
  const CheckedFile* file = FileOf(db);
  return file != nullptr && file->has_checksums;
}

}  // namespace parallax
