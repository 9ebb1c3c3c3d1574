#include "worker/evaluate/benchmarks/benchmark_layout.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "worker/evaluate/disparity_files.h"
#include "worker/evaluate/visibility.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

absl::Status WrongSize(const std::string& path, const ImageF& truth) {
  return InvalidArgument("{}: not of the size of the left disparities, {}x{}", path, truth.width(),
                         truth.height());
}

}  // namespace

absl::StatusOr<std::string> FindFolder(const std::string& dir,
                                       const std::vector<std::string>& candidates) {
  std::error_code error;
  std::string tried;
  for (const std::string& candidate : candidates) {
    const fs::path path = fs::absolute(fs::path(dir) / candidate).lexically_normal();
    if (fs::is_directory(path, error)) return path.string();
    tried += (tried.empty() ? "" : ", ") + candidate;
  }
  return NotFound("{}: has none of the folders {}", dir, tried);
}

std::vector<std::string> SubFolders(const std::string& dir) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    const std::string name = entry.path().filename();
    // Archives of macOS hold __MACOSX beside their folders, and ._NAME beside their files.
    if (name[0] == '.' || name == "__MACOSX") continue;
    if (entry.is_directory(error)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> FilesEnding(const std::string& dir, const std::string& ending) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    const std::string name = entry.path().filename();
    if (name[0] != '.' && name.ends_with(ending) && entry.is_regular_file(error))
      names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool IsFile(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

std::string PlainName(std::string name) {
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '.') c = '_';
  }
  return name;
}

std::vector<std::string> GroupsByName(const std::vector<std::string>& names) {
  std::vector<std::string> groups;
  for (const std::string& name : names) groups.push_back(name.substr(0, name.find('_')));
  const std::set<std::string> different(groups.begin(), groups.end());
  if (different.size() < 2 || different.size() == names.size()) groups.assign(names.size(), "");
  return groups;
}

absl::Status RequireFiles(const std::vector<std::string>& paths) {
  const auto missing = [](const std::string& path) { return !IsFile(path); };
  const auto first = std::find_if(paths.begin(), paths.end(), missing);
  if (first == paths.end()) return absl::OkStatus();
  const auto more = std::count_if(first + 1, paths.end(), missing);
  return NotFound("{}: missing{}", *first,
                  more > 0 ? fmt::format(", and {} more files", more) : "");
}

absl::StatusOr<PairTruth> ReadMiddleburyTruth(const MiddleburyFiles& files) {
  PairTruth truth;
  ASSIGN_OR_RETURN(truth.disparity_px, ReadTruth(files.left));
  const auto fits = [&](const auto& image) {
    return image.width() == truth.disparity_px.width() &&
           image.height() == truth.disparity_px.height();
  };
  if (!files.mask.empty()) {
    ASSIGN_OR_RETURN(const ImageU8 mask, ReadMask(files.mask));
    if (!fits(mask)) return WrongSize(files.mask, truth.disparity_px);
    truth.regions["nocc"] = VisibleOf(mask);
  } else if (!files.right.empty()) {
    ASSIGN_OR_RETURN(const ImageF right, ReadTruth(files.right));
    if (!fits(right)) return WrongSize(files.right, truth.disparity_px);
    truth.regions["nocc"] = VisibleOf(VisibilityMask(truth.disparity_px, right));
  }
  return truth;
}

}  // namespace parallax
