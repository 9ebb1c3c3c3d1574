// Which files a frame's folder has: the one list that its writer, the coordinator's checks and
// tests share.
#pragma once

#include <string>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Of the stage `sensor`, part of its keys: raise it when equal inputs give other pictures.
inline constexpr char kSensorVersion[] = "1";

// What RenderConfig.keep_hdr keeps, left and right: linear R G B as half floats, exposed as the
// 8-bit pictures are (1 is what their tone curve takes for bright), at most kMostLight.
inline constexpr const char* kLinearFiles[2] = {"hdr_left.exr", "hdr_right.exr"};
inline constexpr float kMostLight = 60000;

// Names of the files of one frame, sorted: both images, frame.json, and each map that `render` asks
// for, of both eyes ("depth_left.exr"). Maps that there aren't are left out; the config's own check
// refuses them.
std::vector<std::string> FrameFileNames(const v1::RenderConfig& render);

}  // namespace parallax
