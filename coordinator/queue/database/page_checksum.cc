#include "coordinator/queue/database/page_checksum.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "coordinator/queue/database/vfs_shim.h"

namespace parallax {
namespace {

constexpr int kChecksumBytes = 8;
constexpr int kHeaderBytes = 100;  // What SQLite reads of a file to know it.
constexpr int kReservedAt = 20;    // In the header: the bytes at a page's end that it spares.
constexpr char kMagic[] = "SQLite format 3";
constexpr int kLeastPageBytes = 512;
constexpr int kMostPageBytes = 65536;
constexpr sqlite3_io_methods kPassing = PassingMethods();

struct CheckedFile {
  ShimFile shim;
  bool has_checksums;
};
CheckedFile* Checked(sqlite3_file* file) { return reinterpret_cast<CheckedFile*>(file); }

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
  const int code = kPassing.xRead(file, bytes, amount, offset);
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
    return kPassing.xWrite(file, bytes, amount, offset);
  }
  // On the stack: the last pages are written when the process ends, after its threads' variables.
  std::array<char, kMostPageBytes> copy;
  std::memcpy(copy.data(), page, static_cast<size_t>(amount));
  const uint64_t sum = ChecksumOf(page, amount, offset);
  std::memcpy(copy.data() + amount - kChecksumBytes, &sum, sizeof(sum));
  return kPassing.xWrite(file, copy.data(), amount, offset);
}

constexpr sqlite3_io_methods kMethods = [] {
  sqlite3_io_methods methods = kPassing;
  methods.xRead = Read;
  methods.xWrite = Write;
  return methods;
}();

int Open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) {
    return PassVfs<&sqlite3_vfs::xOpen>(vfs, name, file, flags, out_flags);
  }
  Checked(file)->has_checksums = false;
  return OpenBelow<CheckedFile>(vfs, kMethods, name, file, flags, out_flags);
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
  known->vfs = VfsOver<CheckedFile>(real, known->name.c_str(), Open);
  sqlite3_vfs_register(&known->vfs, 0);
  return known->name;
}

void ReserveChecksums(sqlite3* db) {
  CheckedFile* file = FileOf(db);
  sqlite3_int64 size = 0;
  if (file == nullptr || kPassing.xFileSize(&file->shim.base, &size) != SQLITE_OK || size > 0)
    return;
  int bytes = kChecksumBytes;
  sqlite3_file_control(db, "main", SQLITE_FCNTL_RESERVE_BYTES, &bytes);
  file->has_checksums = true;  // Pages may be written before the first one, which tells of it.
}

bool HasChecksums(sqlite3* db) {
  const CheckedFile* file = FileOf(db);
  return file != nullptr && file->has_checksums;
}

}  // namespace parallax
