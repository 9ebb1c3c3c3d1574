// Tar files of an export's pairs: each holds pairs of one split and is named after it. Private to
// worker/dataset. Not thread-safe.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "common/base/hash.h"
#include "common/base/status.h"
#include "worker/dataset/export/export_layouts.h"

namespace parallax {

struct Shard {
  std::string file;  // "train-000000.tar"
  int pairs = 0;
  int64_t bytes = 0;
  std::string sha256;
};

// Writes the shards of one split pair by pair; only the current pair is in memory.
class ShardWriter {
 public:
  // Shards `folder`/`split`-NNNNNN.tar of at most `pairs_per_shard` pairs.
  ShardWriter(std::string folder, std::string split, int pairs_per_shard);

  // Appends the files of one pair, in their order. Errors: kInvalidArgument for a name of more than
  // 100 characters; as fopen(3) and fwrite(3).
  absl::Status Add(const std::vector<ExportFile>& members);
  // Closes the current shard. Errors: as fwrite(3) and fclose(3).
  absl::Status Finish();
  // Returns the closed shards.
  const std::vector<Shard>& shards() const { return shards_; }

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  absl::Status Open();
  absl::Status Append(const std::string& bytes);

  const std::string folder_, split_;
  const int pairs_per_shard_;
  std::vector<Shard> shards_;
  // The current shard.
  Shard shard_;
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::unique_ptr<Sha256> hash_;
};

// Returns YAML that names the files of each split, for the head of an export's README.md: with it
// Hugging Face `datasets` opens the folder by name.
std::string ShardHead(const std::vector<Shard>& train, const std::vector<Shard>& test);

// Returns Markdown with the table of shards and how to read them.
std::string ShardCard(const std::vector<Shard>& train, const std::vector<Shard>& test);

}  // namespace parallax
