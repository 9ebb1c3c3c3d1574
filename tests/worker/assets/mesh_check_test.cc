// Files of meshes that say what is not so: each is refused with what is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "tests/worker/assets/own_files.h"
#include "worker/assets/files/mesh_file.h"
#include "worker/assets/files/mesh_parts.h"

namespace parallax {
namespace {

using test::BinaryPlyBox;
using test::GlbBox;
using test::GlbWith;
using test::PlyBox;
using ::testing::HasSubstr;

std::string MessageOf(const absl::Status& status) { return std::string(status.message()); }

absl::Status CheckGlb(std::string_view bytes) { return ReadGlb(bytes, "").status(); }
absl::Status CheckPly(std::string_view bytes) { return ReadPly(bytes, "").status(); }

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(GlbCheck, AGoodFilePasses) {
  const std::string box = GlbBox(1, 2, 3);
  EXPECT_TRUE(CheckGlb(box).ok()) << CheckGlb(box);
  const std::string tree =
      GlbWith(box, R"("nodes":[{"mesh":0}])", R"("nodes":[{"children":[2,1]},{"mesh":0},{}])");
  EXPECT_TRUE(CheckGlb(tree).ok()) << CheckGlb(tree);
  const std::string animated =
      GlbWith(box, R"("materials")",
              R"("animations":[{"samplers":[{"input":0,"output":1}],"channels":[]}],"materials")");
  EXPECT_TRUE(CheckGlb(animated).ok()) << CheckGlb(animated);
  const std::string sparse =
      GlbWith(box, R"("count":8,)",
              R"("count":8,"sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},)"
              R"("values":{"bufferView":0}},)");
  EXPECT_TRUE(CheckGlb(sparse).ok()) << CheckGlb(sparse);
}

TEST(GlbCheck, EachBadFileIsToldWhatIsWrong) {
  const struct {
    const char *from, *to, *what;
  } cases[] = {
      {R"("byteOffset":96,)", R"("byteOffset":2147483640,)",
       "view 1: 72 bytes from byte 2147483640 of buffer 0, which has 168"},
      {R"("byteOffset":96,)", R"("byteOffset":18446744073709551600,)",
       "view 1: byteOffset is something else, wanted a whole number from 0 to 2147483647"},
      {R"("byteOffset":96,)", R"("byteOffset":-4,)", "view 1: byteOffset is something else"},
      {R"("buffer":0,"byteOffset":96)", R"("buffer":1,"byteOffset":96)", "view 1: 72 bytes"},
      {R"("count":8,)", R"("count":9,)", "accessor 0: 108 bytes from byte 0 of view 0"},
      {R"("count":8,)", R"("count":2147483647,)",
       "accessor 0: 2147483647 elements, wanted at most 6000000"},
      {R"("byteLength":96})", R"("byteLength":96,"byteStride":2147483647})",
       "accessor 0: 15032385541 bytes from byte 0 of view 0, which has 96"},
      {R"("count":8,)", R"("count":8,"byteOffset":2147483647,)", "accessor 0: 96 bytes from byte"},
      {R"("count":8,)", R"("count":8,"count":9,)", R"(its JSON has "count" twice in one object)"},
      {R"("count":8,)", R"("count":7,)", "mesh 0 part 0: index 8 is 7, wanted less than 7"},
      {R"("componentType":5126)", R"("componentType":5127)", "accessor 0: componentType 5127"},
      {R"("VEC3")", R"("VEC9")", "accessor 0: type is none of SCALAR"},
      {R"("POSITION":0)", R"("POSITION":2)", "mesh 0 part 0: POSITION is accessor 2 of 2"},
      {R"("POSITION":0)", R"("NORMAL":0)", "mesh 0 part 0 has no attribute POSITION"},
      {R"("POSITION":0)", R"("POSITION":0,"NORMAL":1)",
       "mesh 0 part 0: NORMAL has 36 elements, wanted 8, as POSITION"},
      {R"("indices":1)", R"("indices":0)", "mesh 0 part 0: its indices are no unsigned numbers"},
      {R"("indices":1,)", R"("indices":1,"targets":[{"POSITION":1}],)",
       "mesh 0 part 0 target 0: POSITION has 36 elements"},
      {R"("buffers":[{)", R"("buffers":[{"uri":"box.bin",)", "its data lie in another file"},
      {R"("nodes":[{"mesh":0}])", R"("nodes":[{"mesh":0,"children":[0]}])",
       "node 0 stands in two places"},
      {R"("nodes":[{"mesh":0}])", R"("nodes":[{"mesh":0,"children":[1]}])",
       "node 0: children names something that is not there"},
      {R"("nodes":[{"mesh":0}])", R"("nodes":[{"mesh":1}])", "node 0: mesh 1 of 1"},
      {R"("count":8,)",
       R"("count":8,"sparse":{"count":36,"indices":{"bufferView":1,"componentType":5123},)"
       R"("values":{"bufferView":0}},)",
       "accessor 0 sparse: 36 elements of 8"},
      {R"({"asset")", R"(["asset")", "its JSON is damaged or not UTF-8"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.to);
    const absl::Status status = CheckGlb(GlbWith(GlbBox(1, 2, 3), c.from, c.to));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(MessageOf(status), HasSubstr(c.what));
  }
}

TEST(GlbCheck, BadBytesAreToldWhatIsWrong) {
  const std::string box = GlbBox(1, 2, 3);
  std::string old = box, index = box, deep = box;
  old[4] = 1;
  EXPECT_THAT(MessageOf(CheckGlb(old)), HasSubstr("glTF of version 1, wanted 2"));
  index[index.size() - 72] = 8;  // The first index, which is the 97th byte of the data.
  EXPECT_THAT(MessageOf(CheckGlb(index)), HasSubstr("index 0 is 8, wanted less than 8"));
  const std::string lists = std::string(100, '[') + std::string(100, ']');
  deep = GlbWith(box, R"("materials")", R"("extras":)" + lists + R"(,"materials")");
  EXPECT_THAT(MessageOf(CheckGlb(deep)), HasSubstr("its JSON has more than 64 levels"));
  for (size_t length = 0; length < box.size(); length += 7) {
    EXPECT_FALSE(CheckGlb(box.substr(0, length)).ok()) << length;
  }
}

// `count` copies of `item`, separated by commas.
std::string Copies(const std::string& item, int count) {
  std::string all = item;
  for (int i = 1; i < count; ++i) all += "," + item;
  return all;
}

// Few bytes may not stand for many triangles: 400 nodes with 500 parts of a mesh.
TEST(GlbCheck, DataThatAreShownManyTimesCountAsOften) {
  const std::string part = R"({"attributes":{"POSITION":0},"indices":1,"material":0})";
  std::string glb = GlbWith(GlbBox(1, 2, 3), part, Copies(part, 500));
  EXPECT_TRUE(CheckGlb(glb).ok()) << CheckGlb(glb);
  const std::string node = R"({"mesh":0})";
  glb = GlbWith(glb, R"("nodes":[)" + node, R"("nodes":[)" + Copies(node, 400));
  std::string places = "0";
  for (int i = 1; i < 400; ++i) places += "," + std::to_string(i);
  glb = GlbWith(glb, R"("nodes":[0])", R"("nodes":[)" + places + "]");
  EXPECT_THAT(MessageOf(CheckGlb(glb)), HasSubstr("triangles with"));
}

TEST(PlyCheck, GoodFilesPass) {
  EXPECT_TRUE(CheckPly(PlyBox(1, 2, 3)).ok()) << CheckPly(PlyBox(1, 2, 3));
  for (const bool big : {false, true}) {
    const std::string box = BinaryPlyBox(1, 2, 3, big);
    EXPECT_TRUE(CheckPly(box).ok()) << CheckPly(box);
    const std::string path = testing::TempDir() + "ply_check_box.ply";
    ASSERT_TRUE(WriteFile(path, box).ok());
    const auto file = ReadMeshFile(path);
    ASSERT_TRUE(file.ok()) << file.status();
    EXPECT_EQ(file->mesh.triangles.size(), 12u);
    std::filesystem::remove(path);
  }
}

TEST(PlyCheck, EachBadFileIsToldWhatIsWrong) {
  const struct {
    const char *from, *to, *what;
  } cases[] = {
      {"vertex 8", "vertex 4000000000", "4000000000 elements \"vertex\", wanted at most 6000000"},
      {"face 12", "face 2000001", "2000001 elements \"face\", wanted at most 2000000"},
      {"float y", "float w", "its vertices have no property y"},
      {"vertex_indices", "corners", "its element face has no list vertex_indices"},
      {"vertex 8", "vertex many", "\"many\" elements \"vertex\", wanted a whole number"},
      {"face 12", "face 1000000", "its data end within face 12, wanted 1000000 of them"},
      {"3 0 4 6", "3 0 4 8", "face 0: vertex 8, wanted 0 to less than 8"},
      {"3 0 4 6", "3 0 -4 6", "face 0: vertex -4"},
      {"3 0 4 6", "4000000000 0 4 6", "its data end within face 0"},
      {"3 0 4 6", "x 0 4 6", "face 0: a list of nan numbers"},
      {"list uchar", "list float", "wanted a list counted by whole numbers"},
      {"float y", "real y", "property real y: \"real\" is no type"},
      {"ascii", "text", "format \"text\", wanted ascii"},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.to);
    const absl::Status status = CheckPly(Replaced(PlyBox(1, 2, 3), c.from, c.to));
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(MessageOf(status), HasSubstr(c.what));
  }
  const std::string late =
      Replaced(PlyBox(1, 2, 3), "end_header", "comment " + std::string(70'000, 'x'));
  EXPECT_THAT(MessageOf(CheckPly(late)), HasSubstr("no end_header in its first 65536 bytes"));
}

TEST(PlyCheck, BinaryListsMustBeThere) {
  std::string box = BinaryPlyBox(1, 2, 3, false);
  const size_t first_face = box.size() - 12 * 16;
  EXPECT_FALSE(CheckPly(box.substr(0, box.size() - 1)).ok());
  box[first_face + 3] = '\x7f';  // A list of two thousand million numbers.
  EXPECT_THAT(MessageOf(CheckPly(box)), HasSubstr("its data end within face 0"));
  const std::string other = Replaced(box, "vertex_indices", "something_else");
  EXPECT_THAT(MessageOf(CheckPly(other)), HasSubstr("no list vertex_indices"));
}

TEST(PlyCheck, StripsAreCountedWhileTheyAreRead) {
  constexpr uint32_t kCorners = 2'000'003;
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar x\n"
      "property uchar y\nproperty uchar z\nelement tristrips 1\n"
      "property list uint uchar vertex_indices\nend_header\n";
  ply += std::string("\0\0\0\1\0\0\0\1\0", 9);
  ply.append(reinterpret_cast<const char*>(&kCorners), sizeof(kCorners));
  for (uint32_t i = 0; i < kCorners; ++i) ply += static_cast<char>(i % 3);
  EXPECT_THAT(MessageOf(CheckPly(ply)),
              HasSubstr("tristrips 0: 2000001 triangles or more, wanted 1 to 2000000"));
}

TEST(MeshChecks, NameTheFile) {
  const std::string path = testing::TempDir() + "mesh_checks.glb";
  ASSERT_TRUE(WriteFile(path, GlbWith(GlbBox(1, 2, 3), R"("count":8)", R"("count":9)")).ok());
  const absl::Status status = ReadMeshFile(path).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(MessageOf(status), HasSubstr("mesh " + path + ": accessor 0"));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace parallax
