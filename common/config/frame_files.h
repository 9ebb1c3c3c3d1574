// Which files a frame's folder has: the one list that its writer, the coordinator's checks and
// tests share.
#pragma once

#include <string>
#include <vector>

#include "parallax/v1/config.pb.h"

namespace parallax {

// Names of the files of one frame, sorted: both images, frame.json, and each map that `render` asks
// for, of both eyes ("depth_left.exr"). Maps that there aren't are left out; the config's own check
// refuses them.
std::vector<std::string> FrameFileNames(const v1::RenderConfig& render);

}  // namespace parallax
