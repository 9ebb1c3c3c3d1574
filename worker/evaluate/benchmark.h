// Stereo pairs with truth, and how they are judged: one Benchmark for each public set, opened from
// the folders that users download. A kind of benchmark is one file in benchmarks/, registered in
// BenchmarkKinds().
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/ability_tags.h"
#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/evaluate/metrics.h"

namespace parallax {

// Names of what is seen at each pixel, for errors by class or material.
struct LabelMap {
  ImageU16 labels;  // 0: none.
  std::map<uint16_t, std::string> names;
};

// The truth of one pair.
struct PairTruth {
  ImageF disparity_px;                     // Left view; 0 where no truth is known.
  std::map<std::string, ImageU8> regions;  // Beside "all": 1 where a pixel belongs to it.
  std::map<std::string, LabelMap> groups;  // "class", "material".
};

// One pair of a benchmark.
struct BenchmarkPair {
  std::string name;         // Unique in the benchmark; letters, digits, '_', '-', '.'.
  std::string group = {};   // The set of the pair, where pairs of several come together.
  std::string left, right;  // Picture files.
  int shrink = 1;           // The pictures are reduced by this factor before they are predicted.
  // At the resolution of the reduced pictures. Errors: as ReadDisparity.
  std::function<absl::StatusOr<PairTruth>()> read_truth;
};

// A file of a benchmark of the user's own.
struct BenchmarkFile {
  std::string path;  // Absolute.
  std::string name;  // In a copy of the benchmark: relative to its folder.
};

// A benchmark that was opened: its pairs and its figures.
struct Benchmark {
  std::string name;
  Metric headline;              // The figure that it is quoted with.
  std::vector<Metric> figures;  // Others worth printing beside it.
  std::string mimics;           // The implementation whose masks and means the headline follows.
  int pairs_published = 0;      // Pairs of the whole set; 0 where that isn't fixed.
  bool own = false;             // Pairs of the user: they are checked before they are predicted.
  std::vector<BenchmarkPair> pairs;
  // Kinds "list" and "folder" have all files that are read; "list" also has the text of the list
  // for a copy, where files have the names above.
  std::vector<BenchmarkFile> files;
  std::string list;
};

// A kind of benchmark, before it is opened.
struct BenchmarkKind {
  std::string name;         // "middlebury2014-H"; also of the Benchmark that it opens.
  std::string description;  // One line: pairs, figure.
  std::string layout;       // Files that are looked for, below the folder of benchmarks.
  // `dir` is the folder of benchmarks; for the kinds that take a path ("list", "folder",
  // "archive"), that path. Every file is checked to be there.
  std::function<absl::StatusOr<Benchmark>(const std::string& dir)> open;
  bool takes_path = false;
};

// Returns all kinds: those of the paper's table in its order, then the others.
const std::vector<BenchmarkKind>& BenchmarkKinds();

// Where deploy/setup.sh puts the real pair `shipped` for programs of a build. A package has it in
// the folder benchmarks/ of its data (Installation).
inline constexpr char kShippedBenchmarksDir[] = "/opt/parallax/benchmarks";

// Returns the names of the kinds without a path that can be opened in `dir`, in order; those that
// Parallax installs are not among them. Looks for files and reads none.
std::vector<std::string> InstalledBenchmarks(const std::string& dir);

// Opens a benchmark. `what` is a kind's name, or KIND:PATH for kinds that take a path
// ("list:pairs.txt"), or NAME=KIND:PATH to give it a name of its own; without one it is called
// after the file or folder. `dir` is the folder of benchmarks; "shipped" is looked for in
// the place above as well.
// Errors: kInvalidArgument for an unknown name, listing all; kNotFound naming the first missing
// file or what was looked for; kDataLoss for a benchmark without any pair.
absl::StatusOr<Benchmark> OpenBenchmark(const std::string& what, const std::string& dir);

}  // namespace parallax
