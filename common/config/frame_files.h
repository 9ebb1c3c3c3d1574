// The files of a frame's folder: one list for the writer of frames, the coordinator's checks and
// tests. Their names and encodings are those of the table of maps (frame_maps.h).
#pragma once

#include <string>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Version of the stage `sensor`, part of its keys: raise it when equal inputs give other pictures.
inline constexpr char kSensorVersion[] = "2";

// Files that RenderConfig.keep_hdr keeps, left and right: linear R G B as half floats with the
// exposure of the 8-bit pictures (1 is what their tone curve takes for bright), at most kMostLight.
inline constexpr const char* kLinearFiles[2] = {"hdr_left.exr", "hdr_right.exr"};
inline constexpr float kMostLight = 60000;

// 8-bit grey pictures of both eyes under the rig's projector (render.maps: infrared).
inline constexpr const char* kInfraredFiles[2] = {"infrared_left.png", "infrared_right.png"};

// Returns the file names that one frame has at least, sorted: both images, frame.json, and each map
// that `render` asks for, of both eyes ("depth_left.exr"); sparse maps are left out. Unknown maps
// are left out, too; the check of configs refuses them.
std::vector<std::string> FrameFileNames(const v1::RenderConfig& render);

// Returns whether a frame of `render` may have exactly the files `names`, sorted: those above, and
// any of the sparse maps that it asks for.
bool AreFrameFiles(const std::vector<std::string>& names, const v1::RenderConfig& render);

}  // namespace parallax
