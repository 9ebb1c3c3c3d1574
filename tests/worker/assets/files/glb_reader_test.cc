// The reader honours all that a .glb asks for, or refuses it by its name.
#include <cmath>
#include <numbers>

#include "tests/worker/assets/files/mesh_fixture.h"

namespace parallax {
namespace {

using test::ColorAt;
using test::GlbBox;
using test::GlbMaker;
using test::GlbWith;
using test::kByte;
using test::kFloat;
using test::kQuad;
using test::kQuadCorners;
using test::kQuadUv;
using test::kShort;
using test::kUnsignedByte;
using test::kUnsignedShort;
using test::MeshReadersTest;
using test::Quarters;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(MeshReadersTest, IntegerAttributesOfAGlbAreConverted) {
  // The same quad of floats and of integers, normalized and not, with padded elements.
  const std::vector<uint16_t> shorts = {0, 0, 0, 65535, 0, 0, 65535, 65535, 0, 0, 65535, 0};
  const std::vector<int8_t> bytes = {0, 0, 0, 127, 0, 0, 127, 127, 0, 0, 127, 0};
  const std::vector<int16_t> plain = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const std::vector<uint8_t> uv_bytes = {0, 255, 255, 255, 255, 0, 0, 0};
  const std::vector<uint16_t> uv_shorts = {0, 65535, 65535, 65535, 65535, 0, 0, 0};
  const std::string normalized = R"(,"normalized":true)";
  for (const int kind : {0, 1, 2}) {
    GlbMaker maker;
    const int at = kind == 0   ? maker.Add(shorts, kUnsignedShort, "VEC3", normalized)
                   : kind == 1 ? maker.Add(bytes, kByte, "VEC3", normalized)
                               : maker.Add(plain, kShort, "VEC3");
    const int uv = kind == 0   ? maker.Add(uv_shorts, kUnsignedShort, "VEC2", normalized)
                   : kind == 1 ? maker.Add(uv_bytes, kUnsignedByte, "VEC2", normalized)
                               : maker.Add(kQuadUv, kFloat, "VEC2");
    const int corners = maker.Add(kQuadCorners, kUnsignedShort, "SCALAR");
    const int view = maker.AddView(Quarters());
    const MeshFile file = Read(
        "quad.glb",
        maker.Make(fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"indices":{},)"
                               R"("material":0}})",
                               at, uv, corners),
                   fmt::format(R"("extensionsUsed":["KHR_mesh_quantization"],)"
                               R"("extensionsRequired":["KHR_mesh_quantization"],)"
                               R"("images":[{{"bufferView":{}}}],"textures":[{{"source":0}}],)"
                               R"("materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":)"
                               R"({{"index":0}}}}}}],)",
                               view)));
    ASSERT_EQ(file.mesh.triangles.size(), 2u) << kind;
    EXPECT_TRUE(file.mesh.Bounds().sizes().isApprox(Vec3f(1, 0, 1), 1e-4f)) << kind;
    // The file's +x is the asset's -x.
    for (size_t i = 0; i < file.mesh.uv.size(); ++i) {
      EXPECT_NEAR(file.mesh.uv[i].x(), 0.5f - file.mesh.positions[i].x(), 1e-4f) << kind;
      EXPECT_NEAR(file.mesh.uv[i].y(), file.mesh.positions[i].z(), 1e-4f) << kind;
    }
    EXPECT_THAT(file.left_out, IsEmpty());
  }
}

TEST_F(MeshReadersTest, SparseNumbersReplaceOthers) {
  GlbMaker maker;
  const std::vector<uint16_t> places = {2};
  const std::vector<float> values = {1, 5, 0};
  const int place_view =
      maker.AddView(std::string(reinterpret_cast<const char*>(places.data()), 2));
  const int value_view =
      maker.AddView(std::string(reinterpret_cast<const char*>(values.data()), 12));
  maker.Add(
      kQuad, kFloat, "VEC3",
      fmt::format(R"(,"sparse":{{"count":1,"indices":{{"bufferView":{},"componentType":5123}},)"
                  R"("values":{{"bufferView":{}}}}})",
                  place_view, value_view));
  const int corners = maker.Add(kQuadCorners, kUnsignedShort, "SCALAR");
  const MeshFile file =
      Read("sparse.glb",
           maker.Make(fmt::format(R"({{"attributes":{{"POSITION":0}},"indices":{}}})", corners)));
  EXPECT_NEAR(file.mesh.Bounds().sizes().z(), 5, 1e-5f);
}

TEST_F(MeshReadersTest, PicturesLieAsAGlbSays) {
  const MeshFile plain = Read("plain.glb", TexturedQuad(""));
  EXPECT_EQ(plain.materials[0].name, "DefaultMaterial");
  EXPECT_EQ(ColorAt(plain, 0.25f, 0.25f), "r");
  EXPECT_EQ(ColorAt(plain, 0.75f, 0.75f), "gb");
  EXPECT_EQ(ColorAt(plain, 1.25f, 0.25f), "r") << "repeated";

  const MeshFile other = Read("set.glb", TexturedQuad(R"(,"texCoord":1)"));
  for (const Vec2f& uv : other.mesh.uv) EXPECT_EQ(uv, Vec2f(0.5f, 0.5f));

  const auto moved = [&](const std::string& transform) {
    return Read("moved.glb",
                TexturedQuad(R"(,"extensions":{"KHR_texture_transform":{)" + transform + "}}",
                             R"("extensionsRequired":["KHR_texture_transform"],)"));
  };
  const MeshFile offset = moved(R"("offset":[0.5,0])");
  EXPECT_EQ(ColorAt(offset, 0.25f, 0.25f), "g");
  const MeshFile down = moved(R"("offset":[0,0.5])");
  EXPECT_EQ(ColorAt(down, 0.25f, 0.75f), "r");
  EXPECT_EQ(ColorAt(down, 0.25f, 0.25f), "rb");
  const MeshFile scaled = moved(R"("scale":[2,1])");
  EXPECT_EQ(ColorAt(scaled, 0.2f, 0.25f), "r");
  EXPECT_EQ(ColorAt(scaled, 0.3f, 0.25f), "g");
  EXPECT_EQ(ColorAt(scaled, 0.6f, 0.25f), "r");
  // Turned by a quarter, glTF's (u, v down) shows (v, -u): its left lower corner shows (1, 0).
  const MeshFile turned = moved(fmt::format(R"("rotation":{})", std::numbers::pi / 2));
  EXPECT_EQ(ColorAt(turned, 0.1f, 0.1f), "g") << "(0.1, 0.9) shows (0.9, -0.1)";
  EXPECT_EQ(ColorAt(turned, 0.1f, 0.9f), "r") << "(0.1, 0.1) shows (0.1, -0.1)";
  EXPECT_EQ(ColorAt(turned, 0.9f, 0.1f), "gb") << "(0.9, 0.9) shows (0.9, -0.9)";
  for (const Vec2f& uv : moved(R"("texCoord":1)").mesh.uv) EXPECT_EQ(uv, Vec2f(0.5f, 0.5f));
}

TEST_F(MeshReadersTest, PicturesEndAsASamplerSays) {
  const auto wrapped = [&](int s, int t) {
    return Read("wrap.glb",
                TexturedQuad("", fmt::format(R"("samplers":[{{"wrapS":{},"wrapT":{}}}],)", s, t),
                             R"(,"sampler":0)"));
  };
  const MeshFile clamped = wrapped(33071, 33071);
  EXPECT_EQ(ColorAt(clamped, 1.25f, 0.25f), "g");
  EXPECT_EQ(ColorAt(clamped, -3, 7), "rb");
  const MeshFile mirrored = wrapped(33648, 10497);
  EXPECT_EQ(ColorAt(mirrored, 1.25f, 0.25f), "g");
  EXPECT_EQ(ColorAt(mirrored, 1.75f, 0.25f), "r");
  EXPECT_EQ(ColorAt(mirrored, -0.25f, 1.75f), "rb");
  EXPECT_THAT(
      Refusal("wrap.glb", TexturedQuad("", R"("samplers":[{"wrapS":1}],)", R"(,"sampler":0)")),
      HasSubstr("wrapS is 1, wanted 10497, 33071 or 33648"));
}

TEST_F(MeshReadersTest, NeededExtensionsAreKnownOrRefusedByName) {
  const auto with = [](const std::string& json) {
    return GlbWith(GlbBox(1, 1, 1), "\"materials\"", json + ",\"materials\"");
  };
  for (const char* name : {"KHR_texture_basisu", "EXT_texture_webp", "EXT_mesh_gpu_instancing",
                           "EXT_meshopt_compression", "KHR_materials_transmission", "ACME_thing"}) {
    const std::string json = fmt::format(R"("extensionsRequired":["{}"])", name);
    EXPECT_THAT(Refusal("box.glb", with(json)),
                HasSubstr(fmt::format("needs the extension \"{}\"", name)));
  }
  for (const char* name :
       {"KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit"}) {
    Read("box.glb", with(fmt::format(R"("extensionsRequired":["{}"])", name)));
  }
  EXPECT_THAT(Read("box.glb", with(R"("extensionsUsed":["EXT_mesh_gpu_instancing"])")).left_out,
              Contains("EXT_mesh_gpu_instancing"));
  const std::string quad = TexturedQuad("");
  EXPECT_THAT(Refusal("webp.glb", GlbWith(quad, R"("textures":[{"source":0)",
                                          R"("textures":[{"extensions":{"EXT_texture_webp":{}})")),
              HasSubstr("has no PNG or JPEG, only what needs EXT_texture_webp"));
  EXPECT_EQ(
      ColorAt(Read("fallback.glb",
                   GlbWith(quad, R"("textures":[{"source":0)",
                           R"("textures":[{"extensions":{"EXT_texture_webp":{}},"source":0)")),
              0.25f, 0.25f),
      "r");
}

TEST_F(MeshReadersTest, SkinsAndMorphTargetsAreInTheirRestPose) {
  GlbMaker maker;
  const int at = maker.Add(kQuad, kFloat, "VEC3");
  const std::vector<uint8_t> joints(16, 0);
  std::vector<float> weights(16, 0), bind(16, 0), target(12, 0);
  for (size_t i = 0; i < 4; ++i) weights[4 * i] = 1, bind[5 * i] = 1;
  target[7] = 3;  // The third corner's y.
  const int joint = maker.Add(joints, kUnsignedByte, "VEC4");
  const int weight = maker.Add(weights, kFloat, "VEC4");
  const int inverse = maker.Add(bind, kFloat, "MAT4");
  const int moved = maker.Add(target, kFloat, "VEC3");
  const int corners = maker.Add(kQuadCorners, kUnsignedShort, "SCALAR");
  const auto skinned = [&](const std::string& more) {
    return maker.Make(
        fmt::format(
            R"({{"attributes":{{"POSITION":{},"JOINTS_0":{},"WEIGHTS_0":{}{}}},"indices":{}}})", at,
            joint, weight, more, corners),
        fmt::format(R"("skins":[{{"joints":[1],"inverseBindMatrices":{}}}],)", inverse),
        R"({"mesh":0,"skin":0,"scale":[100,100,100],"children":[1]},{"scale":[0.02,0.02,0.02]})");
  };
  const MeshFile skin = Read("skin.glb", skinned(""));
  EXPECT_NEAR(skin.mesh.Bounds().sizes().x(), 2, 1e-4f) << "by its joint, not by its node too";
  EXPECT_THAT(skin.left_out, testing::IsEmpty());
  const std::string eight = fmt::format(R"(,"JOINTS_1":{},"WEIGHTS_1":{})", joint, weight);
  EXPECT_THAT(Read("eight.glb", skinned(eight)).left_out,
              testing::ElementsAre("joints beyond four a corner"));
  const std::string part = fmt::format(
      R"({{"attributes":{{"POSITION":{}}},"indices":{},"targets":[{{"POSITION":{}}}]}})", at,
      corners, moved);
  EXPECT_NEAR(Read("still.glb", maker.Make(part)).mesh.Bounds().sizes().z(), 1, 1e-5f);
  EXPECT_NEAR(Read("morph.glb", maker.Make(part, "", R"({"mesh":0,"weights":[0.5]})"))
                  .mesh.Bounds()
                  .sizes()
                  .z(),
              2.5f, 1e-5f);
}

}  // namespace
}  // namespace parallax
