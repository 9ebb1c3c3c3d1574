#include "worker/evaluate/own_benchmark.h"

#include <filesystem>

#include "common/base/hash.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr char kCopiedList[] = "pairs.txt";

absl::StatusOr<Benchmark> Open(const v1::OwnBenchmark& own, const std::string& path) {
  std::error_code error;
  const bool is_folder = fs::is_directory(path, error);
  const std::string place = !own.list().empty() && is_folder ? path + "/" + kCopiedList : path;
  return OpenBenchmark(own.name() + (own.list().empty() ? "=folder:" : "=list:") + place, "");
}

absl::StatusOr<OwnBenchmarkFiles> FilesOf(const Benchmark& benchmark) {
  OwnBenchmarkFiles read;
  std::vector<ContentFile> files;
  for (const BenchmarkFile& file : benchmark.files) {
    std::error_code error;
    const auto size = fs::file_size(file.path, error);
    if (error) return ErrnoError(error.value(), "read " + file.path);
    ASSIGN_OR_RETURN(const std::string sha256, Sha256HexOfFile(file.path));
    files.push_back({file.name, static_cast<int64_t>(size), sha256});
    read.files.push_back({file.path, files.back()});
  }
  if (!benchmark.list.empty()) {
    read.list = benchmark.list;
    files.push_back({kCopiedList, static_cast<int64_t>(read.list.size()), Sha256Hex(read.list)});
    read.files.push_back({"", files.back()});
  }
  read.sha256 = Sha256Hex(ContentListText(std::move(files)));
  return read;
}

}  // namespace

absl::StatusOr<OwnBenchmarkFiles> ReadOwnBenchmark(const v1::OwnBenchmark& own,
                                                   const std::string& path) {
  ASSIGN_OR_RETURN(const Benchmark benchmark, Open(own, path));
  return FilesOf(benchmark);
}

absl::StatusOr<Benchmark> OpenOwnBenchmark(const v1::OwnBenchmark& own, const std::string& path) {
  ASSIGN_OR_RETURN(Benchmark benchmark, Open(own, path));
  if (own.sha256().empty()) return benchmark;
  ASSIGN_OR_RETURN(const OwnBenchmarkFiles files, FilesOf(benchmark));
  if (files.sha256 == own.sha256()) return benchmark;
  return FailedPrecondition(
      "benchmark {}: the content of {} ({}) is not that of the study ({}): submit the study anew, "
      "or restore the files",
      own.name(), path, files.sha256, own.sha256());
}

}  // namespace parallax
