// The part of a worker's command line that job handlers read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "worker/jobs/files/content_cache.h"
#include "worker/jobs/files/core_share.h"
#include "worker/jobs/files/frame_cache.h"
#include "worker/train/contract/installed_trainers.h"

namespace parallax {

// Filled in after the handlers are made and before any job runs; all handlers see the same.
struct JobOptions {
  std::unique_ptr<CoreShare> cores;  // Null: jobs run without regard to others.
  FrameCacheOptions frame_cache;
  ContentCacheOptions content_cache;
  InstalledTrainers trainers;
  std::string benchmarks_dir;  // Empty: only what is installed with Parallax.

  // Puts both caches into folders of their own inside of `dir`, which may be a mount and may hold
  // other files, for instance the user's store. Each may have `bytes`.
  void SetCaches(const std::string& dir, int64_t bytes) {
    const std::filesystem::path root = std::filesystem::absolute(dir).lexically_normal();
    frame_cache = {root / "frames", bytes};
    content_cache = {root / "content", bytes};
  }
};

}  // namespace parallax
