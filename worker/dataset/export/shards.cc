#include "worker/dataset/export/shards.h"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "worker/dataset/frame/plain_formats.h"

namespace parallax {

ShardWriter::ShardWriter(std::string folder, std::string split, int pairs_per_shard)
    : folder_(std::move(folder)),
      split_(std::move(split)),
      pairs_per_shard_(std::max(1, pairs_per_shard)) {}

absl::Status ShardWriter::Open() {
  shard_ = {.file = fmt::format("{}-{:06}.tar", split_, shards_.size())};
  const std::string path = folder_ + "/" + shard_.file;
  file_.reset(std::fopen(path.c_str(), "wbe"));
  if (file_ == nullptr) return ErrnoError(errno, "create " + path);
  hash_ = std::make_unique<Sha256>();
  return absl::OkStatus();
}

absl::Status ShardWriter::Append(const std::string& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    return ErrnoError(errno, "write " + folder_ + "/" + shard_.file);
  }
  hash_->Update(bytes);
  shard_.bytes += static_cast<int64_t>(bytes.size());
  return absl::OkStatus();
}

absl::Status ShardWriter::Add(const std::vector<ExportFile>& members) {
  if (file_ == nullptr) RETURN_IF_ERROR(Open());
  for (const ExportFile& member : members) {
    ASSIGN_OR_RETURN(const std::string bytes, TarMember(member.path, member.bytes));
    RETURN_IF_ERROR(Append(bytes));
  }
  return ++shard_.pairs < pairs_per_shard_ ? absl::OkStatus() : Finish();
}

absl::Status ShardWriter::Finish() {
  if (file_ == nullptr) return absl::OkStatus();
  RETURN_IF_ERROR(Append(TarEnd()));
  if (std::fclose(file_.release()) != 0) {
    return ErrnoError(errno, "write " + folder_ + "/" + shard_.file);
  }
  shard_.sha256 = HexOf(hash_->Finish());
  shards_.push_back(std::move(shard_));
  return absl::OkStatus();
}

std::string ShardHead(const std::vector<Shard>& train, const std::vector<Shard>& test) {
  std::string head = "configs:\n- config_name: default\n  data_files:\n";
  for (const auto& [split, shards] : {std::pair{"train", &train}, std::pair{"test", &test}}) {
    if (shards->empty()) continue;
    head += std::string("  - split: ") + split + "\n    path: " + split + "-*.tar\n";
  }
  return head;
}

std::string ShardCard(const std::vector<Shard>& train, const std::vector<Shard>& test) {
  std::string table;
  for (const auto& [split, shards] : {std::pair{"train", &train}, std::pair{"test", &test}}) {
    if (shards->empty()) continue;
    int pairs = 0;
    for (const Shard& shard : *shards) pairs += shard.pairs;
    table += fmt::format("| {} | {} | {} |\n", split, shards->size(), pairs);
  }
  return "| split | shards | pairs |\n"
         "|---|---|---|\n" +
         table +
         "\n"
         "```\n"
         "datasets.load_dataset(\"webdataset\", data_files={\"train\": \"train-*.tar\", \"test\": "
         "\"test-*.tar\"})\n"
         "```\n"
         "Each sample has `left.png`, `right.png`, `disp.npy` (float32, pixels of the left view, 0 "
         "= no surface),\n"
         "`occ.png` (255 = not visible in the right eye), where they were rendered "
         "`infrared_{left,right}.png`,\n"
         "`raw_{left,right}.png`, `raw_flow_{left,right}.npy` (x, y in pixels, 1 where known) and "
         "`raw_occlusion_{left,right}.png`, `layers_{left,right}.png` with `depthN_*.npy`, "
         "`disparityN_*.npy`, `objectsN_*.png` and `materialsN_*.png` (what is behind glass and "
         "water, N from 2 to 4), and `json` (camera, tables of objects and "
         "materials as lists of rows;\n"
         "seeds are strings of decimal digits).\n";
}

}  // namespace parallax
