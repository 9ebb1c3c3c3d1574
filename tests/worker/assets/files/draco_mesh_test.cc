// Meshes that Draco has compressed, alone and in a .glb.
#include "worker/assets/files/draco_mesh.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include "tests/worker/assets/files/mesh_fixture.h"

namespace parallax {
namespace {

using test::kQuad;
using test::kQuadCorners;
using test::kQuadUv;
using test::MeshReadersTest;
using ::testing::HasSubstr;

// The quad, with its positions as attribute 0 and coordinates of pictures as 1.
std::string CompressedQuad() {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int at = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  for (uint32_t t = 0; t < 2; ++t) {
    const uint16_t* corners = &kQuadCorners[3 * t];
    builder.SetAttributeValuesForFace(at, draco::FaceIndex(t), &kQuad[3u * corners[0]],
                                      &kQuad[3u * corners[1]], &kQuad[3u * corners[2]]);
    builder.SetAttributeValuesForFace(uv, draco::FaceIndex(t), &kQuadUv[2u * corners[0]],
                                      &kQuadUv[2u * corners[1]], &kQuadUv[2u * corners[2]]);
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return std::string(buffer.data(), buffer.size());
}

TEST(DracoMesh, DecodesTrianglesAndAttributes) {
  const auto mesh = DracoMesh::Decode(CompressedQuad());
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(mesh->Triangles().size(), 2u);
  EXPECT_EQ(mesh->vertices(), 4u);
  const auto positions = mesh->Numbers(0, 3);
  ASSERT_TRUE(positions.ok()) << positions.status();
  EXPECT_EQ(positions->size(), 12u);
  EXPECT_THAT(std::string(mesh->Numbers(7, 3).status().message()), HasSubstr("attribute 7"));
  EXPECT_FALSE(mesh->Numbers(1, 3).ok()) << "two numbers each";
  const std::string whole = CompressedQuad();
  for (size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(DracoMesh::Decode(whole.substr(0, size)).ok()) << size;
  }
}

TEST_F(MeshReadersTest, CompressedPartsOfAGlbAreRead) {
  test::GlbMaker maker;
  const int view = maker.AddView(CompressedQuad());
  const std::string empty = R"({"componentType":5126,"count":4,"type":"VEC3"},)"
                            R"({"componentType":5126,"count":4,"type":"VEC2"},)"
                            R"({"componentType":5123,"count":6,"type":"SCALAR"})";
  std::string glb = maker.Make(
      fmt::format(R"({{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"extensions":)"
                  R"({{"KHR_draco_mesh_compression":{{"bufferView":{},"attributes":)"
                  R"({{"POSITION":0,"TEXCOORD_0":1}}}}}}}})",
                  view),
      R"("extensionsRequired":["KHR_draco_mesh_compression"],)");
  glb = test::GlbWith(glb, R"("accessors":[)", R"("accessors":[)" + empty);
  const MeshFile file = Read("draco.glb", glb);
  EXPECT_EQ(file.mesh.triangles.size(), 2u);
  EXPECT_TRUE(file.mesh.Bounds().sizes().isApprox(Vec3f(1, 0, 1), 1e-3f));
}

}  // namespace
}  // namespace parallax
