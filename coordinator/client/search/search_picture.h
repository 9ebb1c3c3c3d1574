// Draws a search: the trials' errors, what they cost, and the values that the good ones have. Pure.
#pragma once

#include <string>

#include "parallax/v1/search.pb.h"

namespace parallax::client {

// Returns an SVG picture of 960 x 860 pixels: errors by trial and by core-hours of pairs, and
// parallel coordinates of the settings. `search` needs its trials and its study.
std::string SearchSvg(const v1::SearchStatus& search);

}  // namespace parallax::client
