// Tables of cells by their keys, with open addressing: one that threads fill, and one that is only
// read. A key is a hash; 0 is no key.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace parallax {

// Cells that are being filled. A Cell has a `key`, 0 while it is free. Threads may fill different
// shards at the same time.
template <typename Cell>
class CellTable {
 public:
  static constexpr size_t kShards = 64;
  static size_t ShardOf(uint64_t key) { return key >> 58; }

  explicit CellTable(size_t max_cells) : max_per_shard_(max_cells / kShards), shards_(kShards) {}

  // Returns the cell of a key, which is a new one where the table has none; nullptr when it is
  // full.
  Cell* Get(uint64_t key) {
    Shard& shard = shards_[ShardOf(key)];
    if (2 * shard.used >= shard.cells.size()) Grow(&shard);
    Cell& cell = shard.cells[SlotOf(key, shard)];
    if (cell.key == key) return &cell;
    if (shard.used >= max_per_shard_) return nullptr;
    cell.key = key;
    ++shard.used;
    return &cell;
  }
  // Returns nullptr where the table has no such cell.
  const Cell* Find(uint64_t key) const {
    const Shard& shard = shards_[ShardOf(key)];
    if (key == 0 || shard.cells.empty()) return nullptr;
    const Cell& cell = shard.cells[SlotOf(key, shard)];
    return cell.key == key ? &cell : nullptr;
  }
  // Passes each cell of a shard to `use`.
  template <typename Use>
  void ForEachOf(size_t shard, Use use) const {
    for (const Cell& cell : shards_[shard].cells) {
      if (cell.key != 0) use(cell);
    }
  }
  template <typename Use>
  void ForEach(Use use) const {
    for (size_t shard = 0; shard < kShards; ++shard) ForEachOf(shard, use);
  }

  size_t cells() const {
    size_t sum = 0;
    for (const Shard& shard : shards_) sum += shard.used;
    return sum;
  }
  size_t bytes() const {
    size_t sum = 0;
    for (const Shard& shard : shards_) sum += shard.cells.size() * sizeof(Cell);
    return sum;
  }

 private:
  struct Shard {
    std::vector<Cell> cells;  // A power of two.
    size_t used = 0;
  };

  static size_t SlotOf(uint64_t key, const Shard& shard) {
    const size_t mask = shard.cells.size() - 1;
    size_t i = (key >> 1) & mask;
    while (shard.cells[i].key != 0 && shard.cells[i].key != key) i = (i + 1) & mask;
    return i;
  }
  static void Grow(Shard* shard) {
    std::vector<Cell> old(std::max<size_t>(256, 2 * shard->cells.size()));
    old.swap(shard->cells);
    for (const Cell& cell : old) {
      if (cell.key != 0) shard->cells[SlotOf(cell.key, *shard)] = cell;
    }
  }

  size_t max_per_shard_;
  std::vector<Shard> shards_;
};

// Cells that are only read. An Entry has a 32-bit `tag`, part of its key, 0 while it is free.
template <typename Entry>
class FrozenCells {
 public:
  FrozenCells() = default;
  // Has at least so many slots, more than the entries that it will hold.
  explicit FrozenCells(size_t slots) : entries_(std::bit_ceil(std::max<size_t>(slots, 64))) {}

  void Add(uint64_t key, const Entry& entry) {
    size_t i = SlotOf(key);
    while (entries_[i].tag != 0) i = Next(i);
    entries_[i] = entry;
    entries_[i].tag = TagOf(key);
    ++cells_;
  }
  // Returns nullptr where the table, which has been given slots, has no such entry.
  const Entry* Find(uint64_t key) const {
    const uint32_t tag = TagOf(key);
    for (size_t i = SlotOf(key);; i = Next(i)) {
      if (entries_[i].tag == tag) return &entries_[i];
      if (entries_[i].tag == 0) return nullptr;
    }
  }
  void Prefetch(uint64_t key) const { __builtin_prefetch(&entries_[SlotOf(key)]); }

  size_t cells() const { return cells_; }
  size_t bytes() const { return entries_.size() * sizeof(Entry); }

 private:
  static uint32_t TagOf(uint64_t key) { return static_cast<uint32_t>(key >> 32) | 1u; }
  size_t SlotOf(uint64_t key) const { return (key >> 1) & (entries_.size() - 1); }
  size_t Next(size_t i) const { return (i + 1) & (entries_.size() - 1); }

  std::vector<Entry> entries_;  // A power of two.
  size_t cells_ = 0;
};

}  // namespace parallax
