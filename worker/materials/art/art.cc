#include "worker/materials/art/art.h"

#include <array>

#include "worker/materials/art/art_parts.h"

namespace parallax {

std::array<Vec3f, 5> DrawPalette(Rng& rng) {
  static constexpr std::array<std::array<uint32_t, 5>, 14> kPalettes = {
      {{0x22304a, 0xb8402f, 0xd9a23f, 0x5f8f8a, 0xe6dcc4},
       {0x2a2a2c, 0xc23a2f, 0xe0b53a, 0x2f5fa0, 0xe6e4dc},
       {0x2f3a2f, 0x6f8a5a, 0xc9a86a, 0xb0603f, 0xe4dccb},
       {0x3a2238, 0x8f4a6a, 0xd98f7a, 0xe6c08a, 0xe8e0d0},
       {0x1f3f4a, 0x3f7f86, 0x8fb9a8, 0xe0c48a, 0xe4e2d4},
       {0x2a2036, 0x5a3f7f, 0xb06f9a, 0xe0a09a, 0xe6d8d0},
       {0x3a2a20, 0x7f4f33, 0xb98a5a, 0xd9bf95, 0xe6e0d2},
       {0x1f2a3a, 0x3f5f86, 0x86a6bf, 0xc4d0d4, 0xe2e2dc},
       {0x33302e, 0x6f6a66, 0xa39d97, 0xcfc9c2, 0xe6e3de},
       {0x2f4a3a, 0xd97f5f, 0xe6b89a, 0x7fa68f, 0xe8e2d6},
       {0x402a2a, 0xa83f3a, 0xd96f5a, 0xe6a88f, 0xe6d9cc},
       {0x24403f, 0xd9a03f, 0xc25f33, 0x7f3a33, 0xe2d4b5},
       {0x28324f, 0x6f5fa0, 0x5fa0b0, 0xa8d0b0, 0xe6e6c9},
       {0x3f3f2a, 0x8f8a3f, 0xc9b84a, 0xe0d48a, 0xdcdcd0}}};
  const auto& hexes = rng.Pick(kPalettes);
  std::array<Vec3f, 5> palette;
  for (size_t i = 0; i < palette.size(); ++i)
    palette[i] = VaryColor(rng, SrgbColor(hexes[i]), 0.08, 0.05);
  return palette;
}

std::unique_ptr<const Art> DrawArt(Rng& rng, ArtStyle style) {
  auto scene = art::DrawScene(rng, style);
  return scene ? std::move(scene) : art::DrawAbstract(rng, style);
}

std::unique_ptr<const Art> DrawAnyArt(Rng& rng) {
  return DrawArt(rng,
                 static_cast<ArtStyle>(rng.UniformInt(0, static_cast<int>(ArtStyle::kCount) - 1)));
}

}  // namespace parallax
