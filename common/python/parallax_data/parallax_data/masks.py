"""Bits of masks_left.png and masks_right.png."""

SKY = 1          # No surface: depth and disparity are 0.
EXTERIOR = 2     # A surface outside of the rooms: untextured, not for training.
TRANSPARENT = 4  # The first surface lets light through; depth is that surface's.
MIRROR = 8       # The first surface is a mirror, more or less.
MIXED = 16       # Less than half of the samples that make the pixel's colour lie within 1 px of its disparity.
VEILED = 32      # Haze leaves less than a twentieth of the surface to be seen.
