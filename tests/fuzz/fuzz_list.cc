// Lists of the user's own pairs: any text ends in pairs whose copy has the same number, or in an
// error. The files l.png, r.png, "a b.png", d.pfm and d.png are there.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/fuzz/fuzz_folder.h"
#include "worker/evaluate/benchmarks/kinds.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string& dir = parallax::FuzzFolder();
  static const bool made = [&dir] {
    bool good = true;
    for (const char* name : {"l.png", "r.png", "a b.png"}) {
      good &= parallax::WritePng(dir + "/" + name, parallax::ImageRgb8(4, 3, 90)).ok();
    }
    good &= parallax::WritePng(dir + "/d.png", parallax::ImageU16(4, 3, 700)).ok();
    return good && parallax::WritePfm(dir + "/d.pfm", parallax::ImageF(4, 3, 2.5f)).ok();
  }();
  const std::string list = dir + "/pairs.txt";
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (!made || !parallax::WriteFile(list, text).ok()) return 0;
  static const parallax::BenchmarkKind kind = [] {
    std::vector<parallax::BenchmarkKind> kinds;
    parallax::AddPairList(kinds);
    return kinds.front();
  }();
  const auto opened = kind.open(list);
  if (!opened.ok()) return 0;
  for (const parallax::BenchmarkPair& pair : opened->pairs) (void)pair.read_truth();
  // Its copy, as a worker gets it, in which the files have other names.
  const std::string copy = dir + "/copy/";
  std::filesystem::remove_all(copy);
  for (const parallax::BenchmarkFile& file : opened->files) {
    std::filesystem::create_directories(std::filesystem::path(copy + file.name).parent_path());
    (void)parallax::WriteFile(copy + file.name, "");
  }
  if (!parallax::WriteFile(copy + "list.txt", opened->list).ok()) return 0;
  const auto again = kind.open(copy + "list.txt");
  if (!again.ok() || again->pairs.size() != opened->pairs.size()) {
    std::fprintf(stderr, "its copy: %s\n", again.status().ToString().c_str());
    std::abort();
  }
  return 0;
}
