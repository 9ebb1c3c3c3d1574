#include "worker/evaluate/benchmark.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "common/base/edit_distance.h"
#include "worker/evaluate/benchmarks/kinds.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

absl::Status UnknownKind(std::string_view name) {
  std::string known;
  std::vector<std::string> names;
  for (const BenchmarkKind& kind : BenchmarkKinds()) {
    known += (known.empty() ? "" : ", ") + kind.name + (kind.takes_path ? ":PATH" : "");
    names.push_back(kind.name);
  }
  return InvalidArgument("there is no benchmark '{}'{} (there are {})", name,
                         NearestHint(name, names), known);
}

// The last part of a path: "pairs" of "data/pairs.txt", "motorcycles" of "data/motorcycles/".
std::string NameOfPath(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).stem();
}

absl::Status CheckPairs(const Benchmark& benchmark) {
  if (benchmark.pairs.empty()) {
    return DataLoss("{}: has no pairs", benchmark.name);
  }
  std::set<std::string> names;
  for (const BenchmarkPair& pair : benchmark.pairs) {
    if (!names.insert(pair.name).second) {
      return InvalidArgument("{}: two pairs are called {}", benchmark.name, pair.name);
    }
  }
  return absl::OkStatus();
}

}  // namespace

const std::vector<BenchmarkKind>& BenchmarkKinds() {
  static const auto& kinds = *new std::vector<BenchmarkKind>([] {
    std::vector<BenchmarkKind> all;
    AddMiddlebury2014(all);
    AddMiddlebury2021(all);
    AddEth3d(all);
    AddKitti(all);
    AddBooster(all);
    AddMiddlebury2014Sets(all);
    AddDrivingStereo(all);
    AddShipped(all);
    AddPairFolder(all);
    AddPairList(all);
    AddArchive(all);
    return all;
  }());
  return kinds;
}

std::vector<std::string> InstalledBenchmarks(const std::string& dir) {
  std::vector<std::string> names;
  if (dir.empty()) return names;
  for (const BenchmarkKind& kind : BenchmarkKinds()) {
    if (kind.takes_path || kind.name == kShippedBenchmark) continue;
    if (OpenBenchmark(kind.name, dir).ok()) names.push_back(kind.name);
  }
  return names;
}

absl::StatusOr<Benchmark> OpenBenchmark(const std::string& what, const std::string& dir) {
  const size_t equals = what.find('='), colon = what.find(':');
  const bool named = equals != std::string::npos && equals < colon;
  const std::string given = named ? what.substr(0, equals) : "";
  const std::string rest = named ? what.substr(equals + 1) : what;
  const std::string kind_name = rest.substr(0, rest.find(':'));
  const bool has_path = rest.find(':') != std::string::npos;
  const auto& kinds = BenchmarkKinds();
  const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                 [&](const BenchmarkKind& k) { return k.name == kind_name; });
  if (kind == kinds.end() || (has_path && !kind->takes_path)) return UnknownKind(rest);
  if (kind->takes_path && (!has_path || rest.back() == ':')) {
    return InvalidArgument("benchmark '{}': wanted {}:PATH", what, kind->name);
  }
  if (!kind->takes_path && dir.empty() && kind->name != kShippedBenchmark) {
    return InvalidArgument(
        "{}: the folder of benchmarks is not given; name the folder that has it by --benchmarks or "
        "$PARALLAX_BENCHMARKS (`parallax evaluate --list` lists the expected files)",
        kind->name);
  }
  const std::string path = has_path ? rest.substr(kind_name.size() + 1) : dir;
  ASSIGN_OR_RETURN(Benchmark benchmark, kind->open(path));
  benchmark.name = named ? given : has_path ? NameOfPath(path) : kind->name;
  RETURN_IF_ERROR(CheckPairs(benchmark));
  return benchmark;
}

}  // namespace parallax
