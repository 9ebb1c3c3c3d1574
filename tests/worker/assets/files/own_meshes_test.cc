#include "worker/assets/files/own_meshes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <memory>

#include "common/base/system/file.h"
#include "common/base/system/memory_budget.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/assets/own_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using test::GlbBox;
using test::GlbWith;
using test::Mtl;
using test::ObjBox;
using test::PlyBox;
using ::testing::HasSubstr;

class OwnMeshesTest : public FolderTest {
 protected:
  std::string Write(const std::string& name, const std::string& bytes) const {
    const std::string path = dir_ + "/" + name;
    fs::create_directories(fs::path(path).parent_path());
    EXPECT_TRUE(WriteFile(path, bytes).ok());
    return path;
  }
};

// A thing that is 1 wide, 2 high and 3 deep and looks to the front, whichever its format.
TEST_F(OwnMeshesTest, EachFormatGivesTheSameBox) {
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>("box.glb", GlbBox(1, 2, 3)),
                                    {"box.obj", ObjBox(1, 2, 3)},
                                    {"box.PLY", PlyBox(1, 2, 3)}}) {
    const auto file = ReadMeshFile(Write(name, bytes));
    ASSERT_TRUE(file.ok()) << file.status();
    const Box3f bounds = file->mesh.Bounds();
    EXPECT_TRUE(bounds.min().isApprox(Vec3f(-0.5f, -1.5f, 0), 1e-5f)) << name << bounds.min();
    EXPECT_TRUE(bounds.max().isApprox(Vec3f(0.5f, 1.5f, 2), 1e-5f)) << name << bounds.max();
    EXPECT_TRUE(ValidateMesh(file->mesh).ok());
    EXPECT_EQ(file->mesh.triangles.size(), 12u);
    ASSERT_EQ(file->mesh.slots.size(), 1u);
    EXPECT_FALSE(file->mesh.slots[0].sheet) << name << " is closed";
    // Turned outwards.
    for (const Triangle& t : file->mesh.triangles) {
      const auto& p = file->mesh.positions;
      const Vec3f normal = (p[t.b] - p[t.a]).cross(p[t.c] - p[t.a]);
      EXPECT_GT(normal.dot(p[t.a] - bounds.center()), 0) << name;
    }
  }
}

TEST_F(OwnMeshesTest, WhatFacedTheViewerFacesTheFront) {
  // Half of the box's depth is at its front: glTF's +z is the asset frame's +y, and +x its -x.
  std::string obj = ObjBox(1, 1, 1);
  obj += "v 0.1 0.5 9\nf 9 1 2\nf 2 1 9\n";
  const auto file = ReadMeshFile(Write("nose.obj", obj));
  ASSERT_TRUE(file.ok()) << file.status();
  Vec3f nose = Vec3f::Zero();
  for (const Vec3f& p : file->mesh.positions) {
    if (p.y() > nose.y()) nose = p;
  }
  EXPECT_NEAR(nose.y(), 4.5f, 1e-4f);
  EXPECT_GT(nose.x(), 0) << "its left is the viewer's right";
}

TEST_F(OwnMeshesTest, OpenSurfacesAreSheetsWithoutTwins) {
  const auto open = ReadMeshFile(Write("open.glb", GlbBox(1, 1, 1, 10)));
  ASSERT_TRUE(open.ok()) << open.status();
  EXPECT_TRUE(open->mesh.slots[0].sheet);
  EXPECT_EQ(open->mesh.triangles.size(), 10u);
  const auto twins = ReadMeshFile(
      Write("twins.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 3 2 1\nf 1 2 4\n"));
  ASSERT_TRUE(twins.ok()) << twins.status();
  EXPECT_EQ(twins->mesh.triangles.size(), 2u);
}

TEST_F(OwnMeshesTest, BadFilesAreRefusedWithWhatIsWrong) {
  const std::string picture = dir_ + "/elsewhere.png";
  ASSERT_TRUE(WritePng(picture, ImageRgb8(2, 2, 9)).ok());
  Write("in/box.mtl", Mtl("paint", "missing.png"));
  Write("out/box.mtl", Mtl("paint", "../elsewhere.png"));
  Write("text/box.mtl", Mtl("paint", "note.png"));
  Write("text/note.png", "no picture");
  Write("name/box.mtl", Mtl("paint", "paint.dat"));
  Write("name/paint.dat", "no picture");
  const struct {
    const char* name;
    std::string bytes;
    const char* what;
  } cases[] = {
      {"noise.glb", "not a mesh at all", "does not begin as a .glb does"},
      {"noise.obj", "not a mesh at all", "0 triangles, wanted 1 to 2000000"},
      {"empty.ply", "", "does not begin with \"ply\""},
      {"cut.glb", GlbBox(1, 1, 1).substr(0, 200), "is cut: it has 200 of its"},
      {"twice.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
       "property float z\nelement vertex 1\nproperty float x\nproperty float y\n"
       "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
       "0 0 0\n1 0 0\n0 0 1\n2 2 2\n3 0 1 2\n",
       "element vertex twice"},
      {"flat.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", "wanted"},
      {"in/box.obj", ObjBox(1, 1, 1, "paint"), "its picture missing.png"},
      {"out/box.obj", ObjBox(1, 1, 1, "paint"), "lies elsewhere, wanted one beside it"},
      {"text/box.obj", ObjBox(1, 1, 1, "paint"),
       "its picture note.png is neither a PNG nor a JPEG"},
      {"name/box.obj", ObjBox(1, 1, 1, "paint"),
       "its picture paint.dat is named like none, wanted .png, .jpg or .jpeg"},
  };
  for (const auto& c : cases) {
    const std::string path = Write(c.name, c.bytes);
    const auto file = ReadMeshFile(path);
    EXPECT_EQ(file.status().code(), absl::StatusCode::kInvalidArgument) << c.name;
    EXPECT_THAT(std::string(file.status().message()), HasSubstr(c.what));
    EXPECT_THAT(std::string(file.status().message()), HasSubstr(path));
  }
  EXPECT_EQ(ReadMeshFile(dir_ + "/nothing.glb").status().code(), absl::StatusCode::kNotFound);
}

TEST_F(OwnMeshesTest, AreNamedByTheirFolderAndTheirContent) {
  Write("a/chairs/one.glb", GlbBox(1, 2, 1));
  Write("a/chairs/two.obj", ObjBox(1, 2, 2));
  Write("a/tables/one.ply", PlyBox(2, 1, 2));
  const auto meshes = ReadMeshFolders({dir_ + "/a"});
  ASSERT_TRUE(meshes.ok()) << meshes.status();
  ASSERT_EQ(meshes->meshes.size(), 3u);
  EXPECT_EQ(meshes->meshes[0].asset_class, "own:chairs");
  EXPECT_EQ(meshes->meshes[2].asset_class, "own:tables");
  const OwnMesh chair = meshes->meshes[0];
  const auto asset = MakeAsset(chair.asset_class, chair.seed);
  ASSERT_TRUE(asset.ok()) << asset.status();
  EXPECT_FLOAT_EQ(asset->mesh.Bounds().max().z(), 2);

  fs::rename(dir_ + "/a", dir_ + "/b");
  const auto moved = ReadMeshFolders({dir_ + "/b"});
  EXPECT_EQ(moved->sha256, meshes->sha256);
  EXPECT_EQ(moved->meshes[0].seed, chair.seed);
  Write("b/chairs/one.glb", GlbBox(1, 2.5, 1));
  const auto changed = ReadMeshFolders({dir_ + "/b"});
  EXPECT_NE(changed->sha256, meshes->sha256);
  EXPECT_NE(changed->meshes[0].seed, chair.seed);
  EXPECT_EQ(changed->meshes[2].seed, meshes->meshes[2].seed);
}

TEST_F(OwnMeshesTest, TheLooksOfAnObjCountForIt) {
  Write("box/box.obj", ObjBox(1, 1, 1, "paint"));
  Write("box/box.mtl", Mtl("paint", "paint.png"));
  ImageRgb8 picture(8, 8, 0);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 8; ++x) picture(x, y, x < 4 ? 0 : 2) = 200;  // Red left, blue right.
  }
  ASSERT_TRUE(WritePng(dir_ + "/box/paint.png", picture).ok());
  const auto before = ReadMeshFolders({dir_});
  ASSERT_TRUE(before.ok()) << before.status();
  const OwnMesh box = before->meshes.at(0);
  const auto paint = MakeOwnMeshMaterial(OwnMeshMaterial("0"), box.seed);
  ASSERT_TRUE(paint.ok()) << paint.status();
  SurfacePoint point;
  point.footprint_uv = 0.001f;
  point.uv = {0.25f, 0.5f};
  const Vec3f left = (*paint)->Evaluate(point).base_color;
  point.uv = {1.75f, 0.5f};  // Repeated.
  const Vec3f right = (*paint)->Evaluate(point).base_color;
  EXPECT_GT(left.x(), 4 * left.z());
  EXPECT_GT(right.z(), 4 * right.x());
  EXPECT_FALSE(MakeOwnMeshMaterial("mesh:1", box.seed).ok());

  ASSERT_TRUE(WritePng(dir_ + "/box/paint.png", ImageRgb8(8, 8, 9)).ok());
  EXPECT_NE(ReadMeshFolders({dir_})->meshes.at(0).seed, box.seed);
}

TEST_F(OwnMeshesTest, ThePicturesThatAGlbNamesCountForIt) {
  const std::string plain = GlbBox(1, 1, 1);
  Write("box/box.glb", plain);
  const auto seed = [&] { return ReadMeshFolders({dir_})->meshes.at(0).seed; };
  const uint64_t alone = seed();
  ASSERT_TRUE(WritePng(dir_ + "/box/paint.png", ImageRgb8(8, 8, 9)).ok());
  EXPECT_EQ(seed(), alone) << "it names no picture";

  Write("box/box.glb", GlbWith(plain, "\"materials\"",
                               R"("images":[{"uri":"./paint.png"}],)"
                               R"("materials")"));
  const OwnMesh box = ReadMeshFolders({dir_})->meshes.at(0);
  EXPECT_TRUE(OpenOwnMesh(box.asset_class, box.seed).ok());
  ASSERT_TRUE(WritePng(dir_ + "/box/other.png", ImageRgb8(8, 8, 9)).ok());
  EXPECT_EQ(seed(), box.seed);
  ASSERT_TRUE(WritePng(dir_ + "/box/paint.png", ImageRgb8(8, 8, 200)).ok());
  EXPECT_NE(seed(), box.seed);
}

TEST_F(OwnMeshesTest, APictureOfAGlbThatChangesIsNoticed) {
  Write("box/box.glb", GlbWith(GlbBox(1, 1, 1.25), "\"materials\"",
                               R"("images":[{"uri":"paint.png"}],"materials")"));
  ASSERT_TRUE(WritePng(dir_ + "/box/paint.png", ImageRgb8(8, 8, 9)).ok());
  const OwnMesh box = ReadMeshFolders({dir_})->meshes.at(0);
  ASSERT_TRUE(WritePng(dir_ + "/box/paint.png", ImageRgb8(8, 8, 200)).ok());
  EXPECT_EQ(OpenOwnMesh(box.asset_class, box.seed).status().code(), absl::StatusCode::kDataLoss);
}

// Triangles side by side, each with corners of its own.
std::string PlyOfTriangles(int count, float height) {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(3 * count) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(count) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  const auto append = [&ply](const auto& value) {
    ply.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  for (int i = 0; i < count; ++i) {
    const float x = static_cast<float>(i);
    append(std::array<float, 9>{x, 0, 0, x + 0.5f, 0, 0, x, 0, height});
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(count); ++i) {
    ply += '\3';
    append(std::array<uint32_t, 3>{3 * i, 3 * i + 1, 3 * i + 2});
  }
  return ply;
}

TEST_F(OwnMeshesTest, LargeMeshesDoNotStayOpenBesideOthers) {
  constexpr int64_t kRoom = 192 << 20, kBytesOfTriangle = 140;
  // One of them takes about the share of all.
  const int triangles = static_cast<int>((ResidentMemory() + kRoom) / (16 * kBytesOfTriangle));
  Write("large/one.ply", PlyOfTriangles(triangles, 1));
  Write("large/two.ply", PlyOfTriangles(triangles, 2));
  Write("small/box.glb", GlbBox(1, 1, 1.75));
  const OwnMeshes found = *ReadMeshFolders({dir_});
  std::vector<std::weak_ptr<const MeshFile>> files;
  SetMemoryLimit(ResidentMemory() + kRoom);
  for (const OwnMesh& mesh : found.meshes) {
    const auto file = OpenOwnMesh(mesh.asset_class, mesh.seed);
    EXPECT_TRUE(file.ok()) << file.status();
    if (file.ok()) files.push_back(*file);
  }
  SetMemoryLimit(0);
  ASSERT_EQ(files.size(), 3u);
  EXPECT_TRUE(files[0].expired()) << "the two large ones are more than their share";
  EXPECT_FALSE(files[2].expired()) << "the newest stays";
}

TEST_F(OwnMeshesTest, TheClassOfAFolderThatIsNamedCountsForItsContent) {
  Write("all/chairs/one.glb", GlbBox(1, 2, 1));
  const auto before = ReadMeshFolders({dir_ + "/all/chairs"});
  ASSERT_TRUE(before.ok()) << before.status();
  EXPECT_EQ(before->sha256, ReadMeshFolders({dir_ + "/all"})->sha256) << "the same class";
  fs::rename(dir_ + "/all/chairs", dir_ + "/all/tables");
  const auto renamed = ReadMeshFolders({dir_ + "/all/tables"});
  EXPECT_EQ(renamed->meshes.at(0).asset_class, "own:tables");
  EXPECT_EQ(renamed->meshes.at(0).seed, before->meshes.at(0).seed);
  EXPECT_NE(renamed->sha256, before->sha256);
}

TEST_F(OwnMeshesTest, GltfsNumbersAreTheMaterials) {
  Write("box/box.glb", GlbBox(1, 1, 1));
  const OwnMesh box = ReadMeshFolders({dir_})->meshes.at(0);
  const auto paint = MakeOwnMeshMaterial("mesh:0", box.seed);
  ASSERT_TRUE(paint.ok()) << paint.status();
  const SurfaceSample sample = (*paint)->Evaluate(SurfacePoint());
  EXPECT_NEAR(sample.base_color.x(), 0.8f, 1e-5f);
  EXPECT_NEAR(sample.base_color.y(), 0.2f, 1e-5f);
  EXPECT_NEAR(sample.metallic, 0.25f, 1e-5f);
  EXPECT_NEAR(sample.roughness, 0.5f, 1e-5f);
}

TEST_F(OwnMeshesTest, OthersThanThoseOfTheFolderAreNotFound) {
  EXPECT_EQ(MakeAsset("own:nothing", 12345).status().code(), absl::StatusCode::kNotFound);
  Write("box/box.glb", GlbBox(1.5, 1, 1));
  const OwnMesh box = ReadMeshFolders({dir_})->meshes.at(0);
  Write("box/box.glb", GlbBox(1, 1.5, 1));
  EXPECT_EQ(MakeAsset(box.asset_class, box.seed).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_EQ(ReadMeshFolders({dir_ + "/none"}).status().code(), absl::StatusCode::kNotFound);
  Write("bad name/box.glb", GlbBox(1, 1, 1));
  const auto bad = ReadMeshFolders({dir_});
  EXPECT_EQ(bad.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(bad.status().message()), HasSubstr("\"bad name\""));
}

}  // namespace
}  // namespace parallax
