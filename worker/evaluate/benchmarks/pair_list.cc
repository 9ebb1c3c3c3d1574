// Any pairs at all, named in a text file.
#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <sstream>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "worker/evaluate/benchmarks/benchmark_layout.h"
#include "worker/evaluate/benchmarks/kinds.h"
#include "worker/evaluate/disparity_files.h"
#include "worker/evaluate/visibility.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// `mask`: 0 leaves a pixel out of everything, 255 is visible, all else occluded.
absl::StatusOr<PairTruth> ReadListedTruth(const std::string& truth_path, const std::string& mask,
                                          std::optional<float> steps) {
  PairTruth truth;
  ASSIGN_OR_RETURN(truth.disparity_px, ReadTruth(truth_path, steps));
  if (mask.empty()) return truth;
  ASSIGN_OR_RETURN(const ImageU8 values, ReadMask(mask));
  if (values.width() != truth.disparity_px.width() ||
      values.height() != truth.disparity_px.height()) {
    return InvalidArgument("{}: not of the size of {}", mask, truth_path);
  }
  truth.regions["nocc"] = VisibleOf(values);
  for (size_t i = 0; i < values.pixels(); ++i) {
    if (values.values()[i] == kMaskUnknown) truth.disparity_px.values()[i] = 0;
  }
  return truth;
}

// "0003_left": the line's number first, so that names are unique and sort as the list does.
std::string PairName(int index, const std::string& left) {
  return PlainName(fmt::format("{:04}_{}", index, fs::path(left).stem().string()));
}

// Splits a row at blanks, and with `commas` at those too. A field that begins with ' or " ends with
// the next one; doubled it counts as one. A field that begins with # begins a comment. Errors:
// kInvalidArgument for a quote without its end.
absl::StatusOr<std::vector<std::string>> SplitRow(std::string_view row, bool commas) {
  const std::string_view separators = commas ? " \t\r\v\f," : " \t\r\v\f";
  std::vector<std::string> fields;
  for (;;) {
    row.remove_prefix(std::min(row.find_first_not_of(separators), row.size()));
    if (row.empty() || row[0] == '#') return fields;
    std::string& field = fields.emplace_back();
    if (row[0] != '"' && row[0] != '\'') {
      field = row.substr(0, row.find_first_of(separators));
      row.remove_prefix(field.size());
      continue;
    }
    const char quote = row[0];
    size_t at = 1;
    for (; at < row.size() && (row[at] != quote || row.substr(at + 1).starts_with(quote)); ++at) {
      field += row[at];
      if (row[at] == quote) ++at;
    }
    if (at >= row.size()) return InvalidArgument("a {} without its end", quote);
    row.remove_prefix(at + 1);
  }
}

// The fields of a row; commas separate them where blanks do not give three or four.
absl::StatusOr<std::vector<std::string>> FieldsOf(std::string_view row) {
  ASSIGN_OR_RETURN(std::vector<std::string> by_blanks, SplitRow(row, /*commas=*/false));
  ASSIGN_OR_RETURN(std::vector<std::string> by_commas, SplitRow(row, /*commas=*/true));
  const auto fits = [](const auto& fields) { return fields.size() == 3 || fields.size() == 4; };
  const bool trailing = std::any_of(by_blanks.begin(), by_blanks.end(),
                                    [](const std::string& f) { return f.ends_with(','); });
  return fits(by_commas) && (trailing || !fits(by_blanks)) ? by_commas : by_blanks;
}

// Reads the number of `scale: 100`, whose value may be a field of its own. Returns nothing for a
// row that is a pair. Errors: kInvalidArgument for anything but a number above 0.
absl::StatusOr<std::optional<float>> ScaleIn(const std::vector<std::string>& fields) {
  constexpr std::string_view kScale = "scale:";
  if (!fields[0].starts_with(kScale)) return std::optional<float>();
  const std::string text =
      fields.size() == 2 && fields[0] == kScale ? fields[1] : fields[0].substr(kScale.size());
  float steps = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), steps);
  const bool number = read.ec == std::errc() && read.ptr == text.data() + text.size();
  if (fields.size() <= 2 && number && std::isfinite(steps) && steps > 0) {
    return std::optional<float>(steps);
  }
  return InvalidArgument("scale: wanted a number above 0, the value of one pixel of disparity");
}

// Returns the name of `group: NAME`, which may be a field of its own and may be empty; nothing for
// a row that is a pair. Errors: kInvalidArgument for more than one name.
absl::StatusOr<std::optional<std::string>> GroupIn(const std::vector<std::string>& fields) {
  constexpr std::string_view kGroup = "group:";
  if (!fields[0].starts_with(kGroup)) return std::optional<std::string>();
  std::string name = fields[0].substr(kGroup.size());
  if (name.empty() && fields.size() == 2) name = fields[1];
  if (fields.size() == (fields[0] == kGroup && !name.empty() ? 2u : 1u)) return name;
  return InvalidArgument("group: wanted one name, of the set of the pairs that follow, or none");
}

// Notes the files of the next pair, and its line in the list of a copy.
void AddToCopy(const std::vector<std::string>& fields, Benchmark& benchmark) {
  constexpr const char* kRoles[] = {"left", "right", "disparity", "mask"};
  for (size_t i = 0; i < fields.size(); ++i) {
    const std::string name = fmt::format("{:04}-{}/{}", benchmark.pairs.size(), kRoles[i],
                                         PlainName(fs::path(fields[i]).filename()));
    benchmark.files.push_back({fields[i], name});
    benchmark.list += (i > 0 ? " " : "") + name;
  }
  benchmark.list += "\n";
}

absl::StatusOr<Benchmark> OpenPairList(const std::string& path) {
  ASSIGN_OR_RETURN(std::string text, ReadFile(path));
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  if (text.find('\0') != std::string::npos) {
    return InvalidArgument("{}: holds a NUL byte: no text file, or UTF-16; wanted UTF-8", path);
  }
  const fs::path base = fs::absolute(path).parent_path();
  const auto absolute = [&](const std::string& file) {
    return (base / file).lexically_normal().string();
  };
  Benchmark benchmark;
  benchmark.own = true;
  benchmark.headline = {.measure = BadAt(2)};
  benchmark.figures = {{.measure = BadAt(2), .region = "nocc"},
                       {.measure = BadAt(1)},
                       {.measure = BadAt(3)},
                       {.measure = kEpeMeasure}};
  benchmark.mimics = "RAFT-Stereo evaluate_stereo.py (all pixels with truth, mean over images)";
  std::vector<std::string> files;
  std::istringstream in(text);
  int number = 0;
  std::optional<float> steps;
  std::string set;
  for (std::string row; std::getline(in, row);) {
    ++number;
    const std::string place = fmt::format("{}:{}", path, number);
    absl::StatusOr<std::vector<std::string>> read = FieldsOf(row);
    if (!read.ok()) return WithContext(read.status(), place);
    std::vector<std::string>& fields = *read;
    if (fields.empty()) continue;
    const absl::StatusOr<std::optional<float>> scale = ScaleIn(fields);
    if (!scale.ok()) return WithContext(scale.status(), place);
    if (*scale) {
      steps = *scale;
      benchmark.list += fmt::format("scale: {}\n", *steps);
      continue;
    }
    const absl::StatusOr<std::optional<std::string>> group = GroupIn(fields);
    if (!group.ok()) return WithContext(group.status(), place);
    if (*group) {
      set = (*group)->empty() ? "" : PlainName(**group);
      benchmark.list += fmt::format("group: {}\n", set);
      continue;
    }
    if (fields.size() < 3 || fields.size() > 4) {
      return InvalidArgument(
          "{}: {} fields, wanted `left right disparity [mask]`; a name with blanks goes into "
          "quotes",
          place, fields.size());
    }
    for (std::string& field : fields) field = absolute(field);
    files.insert(files.end(), fields.begin(), fields.end());
    AddToCopy(fields, benchmark);
    const std::string truth = fields[2], mask = fields.size() > 3 ? fields[3] : "";
    benchmark.pairs.push_back(
        {.name = PairName(static_cast<int>(benchmark.pairs.size()), fields[0]),
         .group = set,
         .left = fields[0],
         .right = fields[1],
         .read_truth = [truth, mask, steps] { return ReadListedTruth(truth, mask, steps); }});
  }
  absl::Status complete = RequireFiles(files);
  if (!complete.ok()) return WithContext(complete, path);
  return benchmark;
}

}  // namespace

void AddPairList(std::vector<BenchmarkKind>& kinds) {
  kinds.push_back({.name = "list",
                   .description = "Your own pairs, one a line: bad-2, all pixels",
                   .layout =
                       "PATH: lines `left right disparity [mask]`, relative to it, names with "
                       "blanks in quotes; disparity .pfm, .npy, .exr or .png (16 bits x256, "
                       "24 bits x1000, 8 bits) or as a line `scale: N` before it says; mask "
                       "255 visible, 0 left out; a line `group: NAME` names the set of the "
                       "pairs after it",
                   .open = OpenPairList,
                   .takes_path = true});
}

}  // namespace parallax
