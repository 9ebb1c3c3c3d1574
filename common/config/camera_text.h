// Describes the cameras of a resolved study in words and numbers, for people. Pure functions;
// thread-safe.
#pragma once

#include <string>
#include <vector>

#include "parallax/v1/study.pb.h"

namespace parallax {

// Returns one line on what the rigs' pictures are like: size, K in pixels of that size, both fields
// of view, baseline, and disparities at 1 and 10 m. A number that is drawn is a range: "1280x720
// px, K fx 698.4 to 1229 fy 698.4 to 1229 cx 640 cy 360 px, field of view 55 to 85 x 32.7 to 54.5
// deg, baseline 0.04 to 0.4 m, disparity 27.9 to 492 px at 1 m, 2.79 to 49.2 px at 10 m". Requires
// a config with all defaults.
std::string DescribeCamera(const v1::RigConfig& rigs);

// Returns the lines of all variants, a line for each camera that differs, with the names of its
// variants in front if there are several cameras.
std::vector<std::string> DescribeCameras(const v1::StudySpec& study);

}  // namespace parallax
