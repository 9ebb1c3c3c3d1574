// Materials that stereo can't match, kept apart. Thread-safe.
#pragma once

#include "worker/materials/material.h"

namespace parallax {

// Fully transparent or a perfect mirror: what a camera sees there is another surface. Such a
// material serves the slots that ask for it (panes, mirrors), but replaces others only when the
// config says `troublesome`.
bool IsTroublesome(const MaterialClass& material);

}  // namespace parallax
