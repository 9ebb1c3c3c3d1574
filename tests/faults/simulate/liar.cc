#include "tests/faults/simulate/liar.h"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>

#include "tests/coordinator/queue/train_fixture.h"

namespace parallax::faults {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEndings[] = {"", "-wal", ".lock"};

void Copy(const std::string& from, const std::string& to) {
  fs::remove(to);
  if (fs::exists(from)) fs::copy_file(from, to);
}

// The database of a farm that began a minute later, with a study of its own.
void MakeAnother(const std::string& path, double unix_s) {
  FakeClock clock;
  clock.Advance(unix_s + 60 - clock.UnixSeconds());
  auto queue = JobQueue::Open(
      {.db_path = path, .clock = &clock, .own_threads = false, .readers = 1, .kinds = &Kinds()});
  if (!queue.ok() || !(*queue)->Submit(MakeStudy({.name = "other", .key = "other"}), "x").ok()) {
    std::abort();
  }
}

std::string FlipBit(const std::string& path, Rng& dice) {
  const auto at =
      static_cast<std::streamoff>(dice.Uniform() * static_cast<double>(fs::file_size(path)));
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  char byte = 0;
  file.seekg(at).get(byte);
  const int bit = dice.UniformInt(0, 7);
  file.seekp(at).put(static_cast<char>(byte ^ (1 << bit)));
  return fmt::format("bit {} of byte {} of the database is flipped", bit, at);
}

}  // namespace

std::string DatabaseLiar::Tell(Lie lie, Rng& dice, double unix_s) {
  lied_ = true;
  const std::string path = folder_ + "/queue.db";
  for (const char* ending : kEndings) Copy(path + ending, folder_ + "/kept" + ending);
  switch (lie) {
    case Lie::kNone:
      return "nothing";
    case Lie::kFlippedBit:
      return FlipBit(path, dice);
    case Lie::kOlder:
      RemoveDatabase();
      Copy(backup_path(), path);
      return "a backup of yesterday is put back";
    case Lie::kAnother:
      RemoveDatabase();
      MakeAnother(folder_ + "/other.db", unix_s);
      Copy(folder_ + "/other.db", path);
      return "another farm's database";
    case Lie::kNoLog:
      fs::remove(path + "-wal");
      fs::remove(path + "-shm");
      return "the log is deleted";
    case Lie::kNoStore:
      if (!fs::exists(folder_ + "/store")) return "there is no store yet";
      fs::rename(folder_ + "/store", folder_ + "/kept-store");
      return "the folder of the store is gone";
  }
  return "";
}

void DatabaseLiar::PutBack() {
  const std::string store = folder_ + "/store";
  if (fs::exists(folder_ + "/kept-store") && !fs::exists(store)) {
    fs::rename(folder_ + "/kept-store", store);
  }
  RemoveDatabase();
  for (const char* ending : kEndings)
    Copy(folder_ + "/kept" + ending, folder_ + "/queue.db" + ending);
}

void DatabaseLiar::RemoveDatabase() {
  for (const char* ending : kEndings) fs::remove(folder_ + "/queue.db" + ending);
  fs::remove(folder_ + "/queue.db-shm");
}

}  // namespace parallax::faults
