// Chairs that share nothing with the four-legged wooden ones of chairs.cc.
#pragma once

#include "worker/assets/furniture/chairs.h"

namespace parallax {

// A hollowed plank on splayed turned legs, sticks in the plank, a bent bow over them.
void AddWindsorChair(kernel::AssetBuilder& b, const ChairParams& p);

// A moulded shell on dowels or wire.
void AddShellChair(kernel::AssetBuilder& b, const ChairParams& p);

// One bent tube and two pads.
void AddCantileverChair(kernel::AssetBuilder& b, const ChairParams& p, const kernel::Noise& noise);

}  // namespace parallax
