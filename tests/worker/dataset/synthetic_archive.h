// A whole archive of synthetic frames, made by the real writers: for everything that reads
// datasets.
#pragma once

#include <string>
#include <vector>

namespace parallax {

struct SyntheticArchive {
  std::vector<std::string> variants = {"a"};
  int scenes = 3;
  int rigs = 2;
  int width_px = 96, height_px = 54;
  bool last_frame_dark = false;  // Fails the filter "dark".
  bool last_frame_missing = false;
  bool keep_hdr = false;
  bool sequence = false;       // Each scene's rigs are a way, with flow.
  bool extras = false;         // Infrared pictures, layers, and a raw pair without distortion.
  std::string sensor = "off";  // A preset; needs keep_hdr.
};

// Writes `dir` (made anew) and, beside it, the store that it links to: `dir`.store. CHECKs on
// errors.
void MakeSyntheticArchive(const std::string& dir, const SyntheticArchive& options = {});

}  // namespace parallax
