// Lists of the user's own pairs: any text ends in pairs whose copy has the same number, or in an
// error. The files l.png, r.png, "a b.png", d.pfm and d.png are there.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/fuzz/fuzz_folder.h"
#include "worker/evaluate/own_benchmark.h"

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
  const auto opened = parallax::OpenBenchmark("list:" + list, "");
  if (!opened.ok()) return 0;
  for (const parallax::BenchmarkPair& pair : opened->pairs) (void)pair.read_truth();
  // Its copy, as a worker gets it.
  parallax::v1::OwnBenchmark own;
  own.set_list("pairs.txt");
  const auto files = parallax::ReadOwnBenchmark(own, list);
  if (!files.ok()) return 0;
  const std::string copy = dir + "/copy.txt";
  std::string there = files->list;
  size_t lines = 0;
  for (const parallax::OwnBenchmarkFile& file : files->files) lines += file.path.empty() ? 0 : 1;
  if (lines < opened->pairs.size() || !parallax::WriteFile(copy, there).ok()) std::abort();
  return 0;
}
