// Texture sets of the user's: which pictures make one, and what surfaces they give.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <limits>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "worker/materials/pictures/pbr_material.h"
#include "worker/materials/pictures/texture_sets.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class TextureSetsTest : public FolderTest {
 protected:
  void Write(const std::string& name, uint8_t red, uint8_t green, uint8_t blue) const {
    ImageRgb8 picture(4, 4);
    for (size_t i = 0; i < picture.values().size(); ++i) {
      picture.values()[i] = i % 3 == 0 ? red : i % 3 == 1 ? green : blue;
    }
    fs::create_directories(fs::path(dir_ + "/" + name).parent_path());
    ASSERT_TRUE(WritePng(dir_ + "/" + name, picture).ok());
  }
  SurfaceSample SampleOf(const TextureSet& set) const {
    const auto material = MakeOwnTexture(set.name, set.seed);
    EXPECT_TRUE(material.ok()) << material.status();
    return (*material)->Evaluate(SurfacePoint());
  }
};

TEST_F(TextureSetsTest, UsualNamesMakeSets) {
  Write("brick_albedo.png", 200, 10, 10);
  Write("brick_roughness.png", 51, 51, 51);
  Write("Bricks076_1K-PNG_Color.png", 10, 200, 10);  // ambientCG
  Write("Bricks076_1K-PNG_Roughness.png", 102, 102, 102);
  Write("Bricks076_1K-PNG_NormalGL.png", 128, 128, 255);
  Write("metal_plate_diff_1k.png", 100, 100, 100);  // Poly Haven
  Write("metal_plate_metal_1k.png", 255, 255, 255);
  Write("metal_plate_nor_gl_1k.png", 128, 128, 255);
  Write("wood/basecolor.png", 10, 10, 200);  // A folder a set.
  Write("wood/preview.png", 1, 2, 3);
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  std::vector<std::string> names;
  for (const TextureSet& set : folder->sets) names.push_back(set.name);
  EXPECT_THAT(names, testing::ElementsAre("own:brick", "own:bricks076_1k_png", "own:metal_plate_1k",
                                          "own:wood"));
  EXPECT_NEAR(SampleOf(folder->sets[0]).roughness, 0.2f, 1e-3f);
  EXPECT_GT(SampleOf(folder->sets[0]).base_color.x(), 0.3f);
  EXPECT_NEAR(SampleOf(folder->sets[1]).roughness, 0.4f, 1e-3f);
  EXPECT_NEAR(SampleOf(folder->sets[2]).metallic, 1, 1e-3f);
  EXPECT_EQ(SampleOf(folder->sets[3]).metallic, 0);
}

TEST_F(TextureSetsTest, NamesOfOtherProgramsMakeSets) {
  Write("brick_Base_Color.png", 200, 10, 10);  // Substance Painter
  Write("brick_Normal_OpenGL.png", 128, 128, 255);
  Write("brick_Roughness.png", 51, 51, 51);
  Write("brick_Metallic.png", 255, 255, 255);
  Write("brick_Mixed_AO.png", 1, 1, 1);
  Write("brick_Height.png", 1, 1, 1);
  Write("moss_Normal_DirectX.png", 128, 0, 255);
  Write("moss_basecolor.png", 10, 200, 10);
  Write("sand-albedo.png", 1, 2, 3);  // FreePBR
  Write("sand_normal-ogl.png", 128, 128, 255);
  Write("T_Wall_BC.png", 10, 10, 200);  // Unreal
  Write("T_Wall_N.png", 128, 128, 255);
  Write("T_Wall_ORM.png", 1, 102, 255);
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  std::vector<std::string> names;
  for (const TextureSet& set : folder->sets) names.push_back(set.name);
  EXPECT_THAT(names, testing::ElementsAre("own:brick", "own:moss", "own:sand", "own:t_wall"));
  EXPECT_THAT(folder->sets[0].maps,
              testing::ElementsAre("colour brick_Base_Color.png", "roughness brick_Roughness.png",
                                   "metal brick_Metallic.png", "normal brick_Normal_OpenGL.png"));
  EXPECT_THAT(folder->sets[0].left_out,
              testing::ElementsAre(HasSubstr("brick_Height.png"), HasSubstr("brick_Mixed_AO.png")));
  EXPECT_THAT(folder->sets[1].maps, testing::Contains("normal, y down moss_Normal_DirectX.png"));
  EXPECT_THAT(folder->sets[2].maps, testing::Contains("normal sand_normal-ogl.png"));
  EXPECT_NEAR(SampleOf(folder->sets[0]).roughness, 0.2f, 1e-3f);
  EXPECT_NEAR(SampleOf(folder->sets[0]).metallic, 1, 1e-3f);
  EXPECT_NEAR(SampleOf(folder->sets[3]).roughness, 0.4f, 1e-3f);
  EXPECT_NEAR(SampleOf(folder->sets[3]).metallic, 1, 1e-3f);
}

// Poly Haven's default download: some of its maps are EXR, grey or coloured.
TEST_F(TextureSetsTest, MapsMayBeExr) {
  Write("wall_diff_1k.png", 200, 10, 10);
  const auto alone = ReadTextureFolder(dir_);
  ASSERT_TRUE(WriteExrY(dir_ + "/wall_rough_1k.exr", ImageF(4, 4, 0.25f)).ok());
  ASSERT_TRUE(WriteExrHalfRgb(dir_ + "/wall_nor_gl_1k.exr", ImageF3(4, 4, 0.5f)).ok());
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_NE(folder->sha256, alone->sha256);
  EXPECT_EQ(folder->sets[0].maps.size(), 3u);
  EXPECT_NEAR(SampleOf(folder->sets[0]).roughness, 0.25f, 0.01f);
  Write("wall_rough_1k.png", 102, 102, 102);
  const auto both = ReadTextureFolder(dir_);
  EXPECT_NEAR(SampleOf(both->sets[0]).roughness, 0.4f, 1e-3f) << "not the EXR";
  EXPECT_THAT(both->sets[0].left_out, testing::ElementsAre(HasSubstr("wall_rough_1k.exr")));
}

TEST_F(TextureSetsTest, MapsWithValuesThatAreNoNumbersAreRefusedByTheirPlace) {
  Write("wall_diff_1k.png", 200, 10, 10);
  ImageF rough(4, 4, 0.25f);
  rough(3, 1) = std::numeric_limits<float>::quiet_NaN();
  ASSERT_TRUE(WriteExrY(dir_ + "/wall_rough_1k.exr", rough).ok());
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_THAT(std::string(CheckTextureSet(folder->sets[0]).message()),
              HasSubstr("wall_rough_1k.exr: a value that is no number (NaN) at column 3, row 1"));
}

TEST_F(TextureSetsTest, NormalsAreNotGrey) {
  Write("wall_diff_1k.png", 200, 10, 10);
  ASSERT_TRUE(WriteExrY(dir_ + "/wall_nor_gl_1k.exr", ImageF(4, 4, 0.25f)).ok());
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_THAT(std::string(CheckTextureSet(folder->sets[0]).message()),
              HasSubstr("wall_nor_gl_1k.exr: EXR without channel R"));
}

// Poly Haven's rough_block_wall, whose name has a word that is a role, with maps that nobody reads.
TEST_F(TextureSetsTest, OtherMapsOfASetAreSkipped) {
  Write("rough_block_wall_diff_1k.png", 200, 10, 10);
  Write("rough_block_wall_rough_1k.png", 51, 51, 51);
  Write("rough_block_wall_nor_gl_1k.png", 128, 128, 255);
  const auto before = ReadTextureFolder(dir_);
  ASSERT_TRUE(before.ok()) << before.status();
  for (const char* map : {"ao", "disp", "arm", "spec", "gloss", "opacity", "height", "bump"}) {
    Write(std::string("rough_block_wall_") + map + "_1k.png", 7, 7, 7);
  }
  Write("rough_block_wall.png", 1, 2, 3);  // A preview.
  Write("metal_plate_preview.png", 1, 2, 3);
  Write("Bricks076_1K-PNG_AmbientOcclusion.png", 7, 7, 7);  // ambientCG
  Write("Bricks076_1K-PNG_Displacement.png", 7, 7, 7);
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  ASSERT_EQ(folder->sets.size(), 1u);
  EXPECT_EQ(folder->sets[0].name, "own:rough_block_wall_1k");
  EXPECT_EQ(folder->sets[0].seed, before->sets[0].seed);
  EXPECT_EQ(folder->sha256, before->sha256);
  EXPECT_NEAR(SampleOf(folder->sets[0]).roughness, 0.2f, 1e-3f);
}

// A folder that cannot be walked to its end is not taken for a smaller one.
TEST_F(TextureSetsTest, AFolderThatCannotBeReadIsAnError) {
  Write("a_albedo.png", 1, 2, 3);
  Write("deep/1/2/3/4/5/6/7/8/brick_albedo.png", 1, 2, 3);
  rlimit limit{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &limit), 0);
  const int next = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  ASSERT_GE(next, 0);
  ::close(next);
  rlimit few = limit;
  few.rlim_cur = static_cast<rlim_t>(next) + 3;  // Fewer than the folders that are open at once.
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  const absl::Status status = ReadTextureFolder(dir_).status();
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &limit), 0);
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()), HasSubstr("walk " + dir_));
  EXPECT_TRUE(ReadTextureFolder(dir_).ok());
  EXPECT_EQ(ReadTextureFolder(dir_ + "/none").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ReadTextureFolder(dir_ + "/a_albedo.png").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(TextureSetsTest, CountByTheirContent) {
  Write("a/brick_albedo.png", 200, 10, 10);
  const auto before = ReadTextureFolder(dir_ + "/a");
  fs::rename(dir_ + "/a", dir_ + "/b");
  EXPECT_EQ(MakeOwnTexture(before->sets[0].name, before->sets[0].seed).status().code(),
            absl::StatusCode::kNotFound);
  const auto moved = ReadTextureFolder(dir_ + "/b");
  EXPECT_EQ(moved->sha256, before->sha256);
  EXPECT_EQ(moved->sets[0].seed, before->sets[0].seed);
  EXPECT_GT(SampleOf(moved->sets[0]).base_color.x(), 0.3f);
  Write("b/brick_albedo.png", 10, 200, 10);
  EXPECT_NE(ReadTextureFolder(dir_ + "/b")->sets[0].seed, before->sets[0].seed);
}

TEST_F(TextureSetsTest, BadSetsAreRefusedWithWhatIsWrong) {
  const auto message = [&] { return std::string(ReadTextureFolder(dir_).status().message()); };
  EXPECT_THAT(message(), HasSubstr("no file of .png, .jpg, .jpeg, .exr"));
  Write("holiday.png", 1, 2, 3);
  EXPECT_THAT(message(), HasSubstr("wanted pictures named like brick_albedo.png"));
  Write("brick_roughness.png", 1, 2, 3);
  EXPECT_THAT(message(), HasSubstr("brick_roughness.png has no albedo"));
  ASSERT_TRUE(WriteFile(dir_ + "/brick_albedo.png", "no picture").ok());
  const auto folder = ReadTextureFolder(dir_);
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_THAT(std::string(CheckTextureSet(folder->sets[0]).message()),
              HasSubstr("brick_albedo.png"));
}

// The slope along u of a normal that leans by 30 degrees against it.
TEST(PbrMaterial, NormalsBendAlongTheirPicture) {
  PbrPictures pictures;
  ImageRgb8 leaning(4, 4);
  for (size_t i = 0; i < leaning.pixels(); ++i) {
    leaning.values()[3 * i] = 191;  // x = 0.5
    leaning.values()[3 * i + 1] = 128;
    leaning.values()[3 * i + 2] = 238;  // z = 0.866
  }
  pictures.normal.emplace().image = leaning;
  SurfacePoint point;
  point.texture_normal = Vec3f::UnitZ();
  Tangents8 tangents;
  tangents.texture[0] = Vec3x8(Vec3f::UnitX());
  tangents.texture[1] = Vec3x8(Vec3f::UnitY());
  tangents.u[0] = Splat(3);  // Three tiles a metre.
  tangents.u[1] = Splat(0);
  tangents.v[0] = Splat(0);
  tangents.v[1] = Splat(3);
  for (const PbrMapping mapping : {PbrMapping::kUv, PbrMapping::kPlane}) {
    const auto material = MakePbrMaterial(pictures, mapping);
    const Dual8 relief = material->Relief(SurfacePoint8({&point, 1}), tangents);
    EXPECT_NEAR(relief.dx[0], -0.577f, 0.02f);
    EXPECT_NEAR(relief.dy[0], 0, 0.02f);
  }
  pictures.normal->turn << 0, 2, -1, 0;  // Its u goes along v, its v against u.
  const Dual8 turned =
      MakePbrMaterial(pictures, PbrMapping::kUv)->Relief(SurfacePoint8({&point, 1}), tangents);
  EXPECT_NEAR(turned.dx[0], 0, 0.02f);
  EXPECT_NEAR(turned.dy[0], -0.577f, 0.02f);
  pictures.normal.reset();
  const auto flat = MakePbrMaterial(pictures, PbrMapping::kUv);
  EXPECT_EQ(flat->Relief(SurfacePoint8({&point, 1}), tangents).dx[0], 0);
  EXPECT_EQ(flat->Height(point), 0);
}

}  // namespace
}  // namespace parallax
