// A study's own benchmark: the files that count, so that they can be hashed and copied to other
// machines, and opening it where it is. Reads files; thread-safe.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/store/content.h"
#include "parallax/v1/train.pb.h"
#include "worker/evaluate/benchmark.h"

namespace parallax {

struct OwnBenchmarkFile {
  std::string path;  // Absolute; empty: `list` of OwnBenchmarkFiles.
  ContentFile file;  // As a copy has it.
};

struct OwnBenchmarkFiles {
  std::vector<OwnBenchmarkFile> files;
  std::string list;    // Kind "list" only: the list by which a copy names its files.
  std::string sha256;  // Hash of the files' list of content; equal for equal copies.
};

// Reads the benchmark at `path`, the folder or list that `own` names, on this machine. Errors:
// those of OpenBenchmark and of reading files.
absl::StatusOr<OwnBenchmarkFiles> ReadOwnBenchmark(const v1::OwnBenchmark& own,
                                                   const std::string& path);

// Opens the benchmark at `path`: the folder or list that `own` names, or the folder of a copy.
// Checks its content by own.sha256, unless that is empty. Errors: those of OpenBenchmark;
// kFailedPrecondition for other content.
absl::StatusOr<Benchmark> OpenOwnBenchmark(const v1::OwnBenchmark& own, const std::string& path);

}  // namespace parallax
