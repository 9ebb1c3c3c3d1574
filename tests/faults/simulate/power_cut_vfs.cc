#include "tests/faults/simulate/power_cut_vfs.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "coordinator/queue/database/vfs_shim.h"

namespace parallax::faults {
namespace {

constexpr size_t kSector = 512;
constexpr sqlite3_io_methods kPassing = PassingMethods();

// A change since the file's last sync: `before` was at `offset`, `after` was written there. A
// truncation has no `after`.
struct Change {
  sqlite3_int64 offset = 0;
  sqlite3_int64 size_before = 0;
  std::string before;
  std::string after;
  bool truncates = false;
};
struct FileState {
  bool created = false;  // And not synced since.
  std::vector<Change> unsynced;
};

struct Disk {
  VfsPlan plan;
  int64_t operations = 0;
  int64_t tried = 0;  // Operations that plan.errors counts.
  bool ended = false;
  std::map<std::string, FileState> files;
};
Disk& TheDisk() {
  static Disk disk;
  return disk;
}

struct CutFile {
  ShimFile shim;
  const char* path;  // SQLite's, lives as long as the file is open.
};
CutFile* Cut(sqlite3_file* file) { return reinterpret_cast<CutFile*>(file); }

void WriteAt(int fd, const std::string& bytes, sqlite3_int64 offset) {
  if (pwrite(fd, bytes.data(), bytes.size(), offset) < 0) std::abort();
}

// Back to what was synced, then a random part of what was not, in random order.
void LosePower(const std::string& path, const FileState& state, Rng& rng) {
  if (state.created && rng.Bernoulli(0.5)) {
    unlink(path.c_str());
    return;
  }
  const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return;
  for (auto change = state.unsynced.rbegin(); change != state.unsynced.rend(); ++change) {
    WriteAt(fd, change->before, change->offset);
    if (ftruncate(fd, change->size_before) != 0) std::abort();
  }
  struct Piece {
    sqlite3_int64 offset;
    std::string bytes;
    bool truncates;
  };
  std::vector<Piece> pieces;
  for (const Change& change : state.unsynced) {
    if (change.truncates) pieces.push_back({change.offset, "", true});
    for (size_t at = 0; at < change.after.size();) {
      const auto offset = change.offset + static_cast<sqlite3_int64>(at);
      const size_t room = kSector - static_cast<size_t>(offset) % kSector;
      pieces.push_back({offset, change.after.substr(at, room), false});
      at += room;
    }
  }
  rng.Shuffle(pieces);
  // Sometimes all of it is there, sometimes nothing, mostly some.
  const double kept = std::clamp(rng.Uniform(-0.25, 1.25), 0.0, 1.0);
  for (Piece& piece : pieces) {
    if (!rng.Bernoulli(kept)) continue;
    if (piece.truncates) {
      if (ftruncate(fd, piece.offset) != 0) std::abort();
      continue;
    }
    if (rng.Bernoulli(0.05)) piece.bytes.resize(piece.bytes.size() / 2);
    WriteAt(fd, piece.bytes, piece.offset);
  }
  close(fd);
}

void End(Disk& disk, bool lose_unsynced) {
  if (lose_unsynced) {
    Rng rng(SceneSeed{disk.plan.seed}, "power-cut");
    for (const auto& [path, state] : disk.files) LosePower(path, state, rng);
  }
  disk.ended = true;
}

// Returns false when the machine has ended, with this operation or before.
bool CountOperation(Disk& disk) {
  if (disk.ended) return false;
  if (++disk.operations == disk.plan.die_at) End(disk, disk.plan.lose_unsynced);
  return !disk.ended;
}

enum class Kind { kRead, kWrite, kOther };

bool Errs(Disk& disk, Kind kind) {
  const DiskErrors& errors = disk.plan.errors;
  if (errors.at < 0 ||
      (errors.full ? kind != Kind::kWrite : kind == Kind::kRead && !errors.reads)) {
    return false;
  }
  ++disk.tried;
  return disk.tried >= errors.at && disk.tried < errors.at + errors.count;
}

int Write(sqlite3_file* file, const void* bytes, int amount, sqlite3_int64 offset) {
  Disk& disk = TheDisk();
  if (disk.ended) return SQLITE_IOERR_WRITE;
  if (Errs(disk, Kind::kWrite)) return disk.plan.errors.full ? SQLITE_FULL : SQLITE_IOERR_WRITE;
  FileState& state = disk.files[Cut(file)->path];
  if (disk.plan.lose_unsynced) {
    Change change;
    change.offset = offset;
    kPassing.xFileSize(file, &change.size_before);
    const auto there = std::clamp<sqlite3_int64>(change.size_before - offset, 0, amount);
    change.before.resize(static_cast<size_t>(there));
    if (there > 0) {
      kPassing.xRead(file, change.before.data(), static_cast<int>(there), offset);
    }
    change.after.assign(static_cast<const char*>(bytes), static_cast<size_t>(amount));
    state.unsynced.push_back(std::move(change));
  }
  // The write at which it ends counts as under way: it may be there in part.
  if (!CountOperation(disk)) return SQLITE_IOERR_WRITE;
  return kPassing.xWrite(file, bytes, amount, offset);
}

int Truncate(sqlite3_file* file, sqlite3_int64 size) {
  Disk& disk = TheDisk();
  if (disk.ended || Errs(disk, Kind::kOther)) return SQLITE_IOERR_TRUNCATE;
  FileState& state = disk.files[Cut(file)->path];
  if (disk.plan.lose_unsynced) {
    Change change;
    change.offset = size;
    change.truncates = true;
    kPassing.xFileSize(file, &change.size_before);
    change.before.resize(
        static_cast<size_t>(std::max<sqlite3_int64>(0, change.size_before - size)));
    if (!change.before.empty()) {
      kPassing.xRead(file, change.before.data(), static_cast<int>(change.before.size()), size);
    }
    state.unsynced.push_back(std::move(change));
  }
  if (!CountOperation(disk)) return SQLITE_IOERR_TRUNCATE;
  return kPassing.xTruncate(file, size);
}

int Sync(sqlite3_file* file, int) {
  Disk& disk = TheDisk();
  if (Errs(disk, Kind::kOther) || !CountOperation(disk)) return SQLITE_IOERR_FSYNC;
  // The real one would only cost time: it is this file that decides what survives.
  FileState& state = disk.files[Cut(file)->path];
  state.unsynced.clear();
  state.created = false;
  return SQLITE_OK;
}

int Read(sqlite3_file* file, void* bytes, int amount, sqlite3_int64 offset) {
  Disk& disk = TheDisk();
  if (Errs(disk, Kind::kRead)) return SQLITE_IOERR_READ;
  return kPassing.xRead(file, bytes, amount, offset);
}
constexpr sqlite3_io_methods kMethods = [] {
  sqlite3_io_methods methods = kPassing;
  methods.xRead = Read;
  methods.xWrite = Write;
  methods.xTruncate = Truncate;
  methods.xSync = Sync;
  return methods;
}();

int Open(sqlite3_vfs* vfs, sqlite3_filename name, sqlite3_file* file, int flags, int* out_flags) {
  if (name == nullptr) return SQLITE_CANTOPEN;
  Cut(file)->path = name;
  const bool known = access(name, F_OK) == 0;
  const int code = OpenBelow<CutFile>(vfs, kMethods, name, file, flags, out_flags);
  if (code != SQLITE_OK) return code;
  Disk& disk = TheDisk();
  if (!known) disk.files[name].created = true;
  return code;
}

int Delete(sqlite3_vfs* vfs, const char* name, int sync_folder) {
  Disk& disk = TheDisk();
  if (Errs(disk, Kind::kOther) || !CountOperation(disk)) return SQLITE_IOERR_DELETE;
  disk.files.erase(name);
  return PassVfs<&sqlite3_vfs::xDelete>(vfs, name, sync_folder);
}

}  // namespace

void RegisterPowerCutVfs() {
  static sqlite3_vfs vfs;
  if (vfs.pAppData != nullptr) return;
  // As SqliteConnection does, but before SQLite begins, which it does here.
  sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0);
  vfs = VfsOver<CutFile>(sqlite3_vfs_find(nullptr), kPowerCutVfs, Open);
  vfs.xDelete = Delete;
  sqlite3_vfs_register(&vfs, 0);
}

void SetVfsPlan(const VfsPlan& plan) {
  Disk& disk = TheDisk();
  disk.plan = plan;
  disk.operations = disk.tried = 0;
  disk.ended = false;
  disk.files.clear();
}

void EndVfs(bool lose_unsynced) {
  Disk& disk = TheDisk();
  if (!disk.ended) End(disk, lose_unsynced);
}

void MendDisk() { TheDisk().plan.errors = {}; }

bool VfsHasEnded() { return TheDisk().ended; }

}  // namespace parallax::faults
