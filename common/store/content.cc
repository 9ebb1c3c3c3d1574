#include "common/store/content.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "common/store/store.h"

namespace parallax {
namespace {

constexpr std::string_view kFirstLine = "parallax-content 1";
constexpr std::string_view kReferencePrefix = "store:";
constexpr size_t kHashDigits = 64;

bool IsHash(std::string_view text) {
  return text.size() == kHashDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

absl::Status BadLine(size_t number, const std::string& what) {
  return InvalidArgument("list of content, line {}: {}", number, what);
}

// "<hash> <size> <name>"
absl::StatusOr<ContentFile> ParseContentLine(std::string_view line, size_t number) {
  ContentFile file;
  const size_t end = line.find(' ', kHashDigits + 1);
  if (line.size() < kHashDigits + 4 || line[kHashDigits] != ' ' || end == std::string_view::npos ||
      !IsHash(line.substr(0, kHashDigits))) {
    return BadLine(number, "wanted is a hash, a size and a name");
  }
  file.sha256 = line.substr(0, kHashDigits);
  const std::string_view size = line.substr(kHashDigits + 1, end - kHashDigits - 1);
  const auto [at, error] = std::from_chars(size.data(), size.data() + size.size(), file.size);
  if (error != std::errc() || at != size.data() + size.size() || file.size < 0) {
    return BadLine(number, "its size is no number of bytes");
  }
  file.name = line.substr(end + 1);
  const absl::Status name = CheckStorePath(file.name);
  if (!name.ok()) return BadLine(number, std::string(ToStd(name.message())));
  return file;
}

}  // namespace

std::string ContentPath(std::string_view sha256) {
  return std::string(kContentFolder) + "/" + std::string(sha256.substr(0, 2)) + "/" +
         std::string(sha256);
}

bool IsBelowContent(std::string_view path) {
  return path == kContentFolder || path.starts_with(std::string(kContentFolder) + "/");
}

std::string ContentListText(std::vector<ContentFile> files) {
  std::sort(files.begin(), files.end(),
            [](const ContentFile& a, const ContentFile& b) { return a.name < b.name; });
  std::string text = std::string(kFirstLine) + "\n";
  for (const ContentFile& file : files) {
    text += fmt::format("{} {} {}\n", file.sha256, file.size, file.name);
  }
  return text;
}

absl::StatusOr<std::vector<ContentFile>> ParseContentList(std::string_view text) {
  std::vector<ContentFile> files;
  std::set<std::string_view> names;
  if (text.size() > kMostContentListBytes) return BadLine(1, "it is too long");
  for (size_t begin = 0, number = 1; begin < text.size(); ++number) {
    const size_t end = text.find('\n', begin);
    if (end == std::string_view::npos) return BadLine(number, "it has no end");
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    if (number == 1) {
      if (line != kFirstLine) return BadLine(1, "wanted is \"" + std::string(kFirstLine) + "\"");
      continue;
    }
    ASSIGN_OR_RETURN(ContentFile file, ParseContentLine(line, number));
    if (!names.insert(line.substr(line.size() - file.name.size())).second) {
      return BadLine(number, file.name + " is listed twice");
    }
    files.push_back(std::move(file));
  }
  if (files.empty()) return BadLine(1, "it names no file");
  RETURN_IF_ERROR(CheckContentSizes(files, "list of content"));
  return files;
}

absl::Status CheckContentSizes(const std::vector<ContentFile>& files, const std::string& folder) {
  const auto refuse = [&folder](const std::string& what) {
    return InvalidArgument("{}: {}", folder, what);
  };
  if (files.size() > kMostContentFiles) {
    return refuse(fmt::format("{} files, allowed are {}", files.size(), kMostContentFiles));
  }
  int64_t bytes = 0;
  for (const ContentFile& file : files) {
    bytes += file.size;
    if (file.size > kMostContentFileBytes) {
      return refuse(fmt::format("{} has {} bytes, allowed are {} a file", file.name, file.size,
                                kMostContentFileBytes));
    }
    if (bytes > kMostContentBytes) {
      return refuse(fmt::format("its files have more than {} bytes together, which are allowed",
                                kMostContentBytes));
    }
  }
  return absl::OkStatus();
}

std::string ContentReferenceText(const ContentReference& reference) {
  return std::string(kReferencePrefix) + reference.sha256 + "/" + reference.path;
}

std::optional<ContentReference> FindContentReference(std::string_view text) {
  if (!text.starts_with(kReferencePrefix)) return std::nullopt;
  text.remove_prefix(kReferencePrefix.size());
  if (text.size() <= kHashDigits + 1 || text[kHashDigits] != '/' ||
      !IsHash(text.substr(0, kHashDigits))) {
    return std::nullopt;
  }
  return ContentReference{std::string(text.substr(0, kHashDigits)),
                          std::string(text.substr(kHashDigits + 1))};
}

}  // namespace parallax
