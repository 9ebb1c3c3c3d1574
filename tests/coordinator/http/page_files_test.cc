// The page's own files fit its policy and each other.
#include "coordinator/http/page_files.h"

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>

namespace parallax {
namespace {

std::set<std::string> Paths() {
  std::set<std::string> paths;
  for (const PageFile& file : PageFiles()) paths.emplace(file.path);
  return paths;
}

TEST(PageFiles, NameNothingThatIsNotThere) {
  const std::set<std::string> paths = Paths();
  const std::regex named("(?:from |src=|href=)\"(/?[./]*[a-z][a-z/.-]*\\.(?:js|css|svg))\"");
  int found = 0;
  for (const PageFile& file : PageFiles()) {
    const std::string text(file.bytes);
    for (std::sregex_iterator match(text.begin(), text.end(), named), end; match != end; ++match) {
      std::string path = (*match)[1];
      if (path.rfind("./", 0) == 0) path = "/js" + path.substr(1);
      EXPECT_EQ(paths.count(path), 1u) << file.path << " names " << path;
      ++found;
    }
  }
  EXPECT_GT(found, 20);
}

TEST(PageFiles, HaveNoScriptOrStyleThatThePolicyRefuses) {
  for (const PageFile& file : PageFiles()) {
    if (file.path.rfind("/vendor/", 0) == 0) continue;
    const std::string text(file.bytes);
    for (const char* refused : {"<style", " style=", "javascript:", "eval(", "new Function",
                                "innerHTML", "http://", "https://"}) {
      // A namespace is no address that is fetched.
      if (file.path == "/favicon.svg" && std::string(refused) == "http://") continue;
      EXPECT_EQ(text.find(refused), std::string::npos) << file.path << " has " << refused;
    }
    static const std::regex kInline("<script(?![^>]*src=)");
    EXPECT_FALSE(std::regex_search(text, kInline)) << file.path;
  }
}

TEST(PageFiles, AreSmallAndToldApartByTheirContent) {
  size_t bytes = 0;
  std::set<std::string> etags;
  for (const PageFile& file : PageFiles()) {
    bytes += file.bytes.size();
    EXPECT_TRUE(etags.emplace(file.etag).second) << file.path;
    EXPECT_FALSE(file.bytes.empty()) << file.path;
  }
  EXPECT_LT(bytes, 150'000u);
  EXPECT_EQ(Paths().count("/"), 1u);
}

}  // namespace
}  // namespace parallax
