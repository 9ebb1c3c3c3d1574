// A whole archive of synthetic frames, made by the real writers: for everything that reads
// datasets.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
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

// Changes each line of the index of variant "a" of the archive in `dir`.
void ChangeIndex(const std::string& dir,
                 const std::function<void(nlohmann::ordered_json& line)>& change);

// Puts other bytes in place of a file of variant "a", scene 0, rig 1 (not through its hard link)
// and makes the index agree, so that only geometry can notice.
void ForgeFile(const std::string& dir, const std::string& name, const std::string& bytes);

}  // namespace parallax
