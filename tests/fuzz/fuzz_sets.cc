// Names of pictures in a user's folder: any names end in sets of textures whose pictures can be
// opened, or in an error. The input is a name a line.
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/fuzz/fuzz_folder.h"
#include "worker/materials/pictures/texture_sets.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string png = *parallax::EncodePng(parallax::ImageRgb8(2, 2, 90));
  static const std::string exr = *parallax::EncodeExrRgb(parallax::ImageF3(2, 2, 0.4f));
  const std::string dir = parallax::FuzzFolder() + "/sets";
  std::error_code error;
  std::filesystem::remove_all(dir, error);
  std::filesystem::create_directories(dir, error);
  std::istringstream names(std::string(reinterpret_cast<const char*>(data), size));
  int count = 0;
  for (std::string name; std::getline(names, name) && count < 12; ++count) {
    if (name.find('/') != name.npos || name.find('\0') != name.npos) continue;
    std::string lower = name;
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    (void)parallax::WriteFile(dir + "/" + name, lower.ends_with(".exr") ? exr : png);
  }
  const auto folder = parallax::ReadTextureFolder(dir);
  if (!folder.ok()) return 0;
  for (const parallax::TextureSet& set : folder->sets) {
    if (const absl::Status good = parallax::CheckTextureSet(set); !good.ok()) {
      std::fprintf(stderr, "%s: %s\n", set.name.c_str(), good.ToString().c_str());
      std::abort();
    }
    if (set.maps.size() + set.left_out.size() > static_cast<size_t>(count)) std::abort();
  }
  return 0;
}
