// Materials on which stereo matching fails, kept apart. Thread-safe.
#pragma once

#include "worker/materials/kernel/material.h"

namespace parallax {

// Returns whether a material is fully transparent or a perfect mirror, so that cameras see another
// surface in it. Such materials serve the slots that ask for them (panes, mirrors), but replace
// others only when the config says `troublesome`.
bool IsTroublesome(const MaterialClass& material);

}  // namespace parallax
