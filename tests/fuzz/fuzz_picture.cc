// Pictures, truth and skies as users bring them: any bytes end in a picture whose values have the
// size that it says, or in an error. The first byte chooses the ending of the file's name.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/base/system/file.h"
#include "common/image/hdr.h"
#include "common/image/jpeg.h"
#include "common/image/picture_pair.h"
#include "tests/fuzz/fuzz_folder.h"
#include "worker/evaluate/disparity_files.h"

namespace {

template <typename Image>
void Check(const absl::StatusOr<Image>& image) {
  if (!image.ok()) return;
  if (image->width() > 0 && image->height() > 0 && !image->values().empty()) return;
  std::fprintf(stderr, "a picture without pixels was accepted\n");
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  const char* const endings[] = {"png", "jpg", "pfm", "npy", "exr", "hdr", "ppm"};
  const std::string ending = endings[data[0] % 7];
  const std::string path = parallax::FuzzFolder() + "/picture." + ending;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (!parallax::WriteFile(path, bytes).ok()) return 0;
  if (ending == "hdr") {
    Check(parallax::DecodeHdr(bytes));
    return 0;
  }
  if (ending == "exr") Check(parallax::DecodeExrPicture(bytes));
  if (ending != "jpg" && ending != "ppm") {
    Check(parallax::ReadTruth(path));
    Check(parallax::ReadTruth(path, 100.0f));
  }
  if (ending == "pfm" || ending == "npy" || ending == "exr") return 0;
  Check(parallax::ReadMask(path));
  Check(parallax::ReadPictureRgb8(path));
  const auto pair = parallax::ReadPicturePair(path, path);
  if (pair.ok()) Check(absl::StatusOr<parallax::ImageRgb8>(pair->left));
  if (pair.ok() && !parallax::CheckPicture(path).ok()) {
    std::fprintf(stderr, "a predictor reads a picture that its check refuses\n");
    std::abort();
  }
  return 0;
}
