// The readers honour all that files of meshes ask for, or name it as left out.
#include <cmath>
#include <numbers>
#include <set>

#include "tests/worker/assets/files/mesh_fixture.h"

namespace parallax {
namespace {

using test::ColorAt;
using test::GlbBox;
using test::GlbMaker;
using test::GlbWith;
using test::kFloat;
using test::kQuad;
using test::kUnsignedShort;
using test::MeshReadersTest;
using test::Mtl;
using test::ObjBox;
using test::Quarters;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST_F(MeshReadersTest, PartsWithoutCoordinatesLeaveOthersTheirPictures) {
  const std::string part = R"({"attributes":{"POSITION":0},"indices":3,"material":0},)";
  const std::string glb =
      GlbWith(TexturedQuad(""), R"("primitives":[)", R"("primitives":[)" + part);
  const MeshFile file = Read("two.glb", glb);
  ASSERT_EQ(file.materials.size(), 2u);
  EXPECT_THAT(file.materials[0].maps, IsEmpty());
  EXPECT_THAT(file.materials[1].maps, testing::ElementsAre("colour inside"));
  EXPECT_THAT(file.left_out, Contains(HasSubstr("on parts without their texture coordinates")));

  Write("two.mtl", Mtl("paint", "a.png"));
  Write("a.png", Quarters());
  const MeshFile obj = Read("two.obj",
                            "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\n"
                            "vt 1 1\nusemtl paint\nf 1 3 4\nf 1/1 2/2 3/3\n");
  ASSERT_EQ(obj.materials.size(), 2u);
  EXPECT_EQ(obj.materials[0].maps.size() + obj.materials[1].maps.size(), 1u);
}

TEST_F(MeshReadersTest, StripsAndFansAreTriangles) {
  const auto area_up = [](const MeshFile& file) {  // Towards the asset's front.
    float area = 0;
    for (const Triangle& t : file.mesh.triangles) {
      const auto& p = file.mesh.positions;
      area += 0.5f * (p[t.b] - p[t.a]).cross(p[t.c] - p[t.a]).y();
    }
    return area;
  };
  GlbMaker maker;
  maker.Add(kQuad, kFloat, "VEC3");
  const std::vector<uint16_t> zigzag = {0, 1, 3, 2}, round = {0, 1, 2, 3};
  const int strip = maker.Add(zigzag, kUnsignedShort, "SCALAR");
  const int fan = maker.Add(round, kUnsignedShort, "SCALAR");
  for (const auto& [indices, mode] : {std::pair(strip, 5), {fan, 6}}) {
    const MeshFile file =
        Read("quad.glb",
             maker.Make(fmt::format(R"({{"attributes":{{"POSITION":0}},"indices":{},"mode":{}}})",
                                    indices, mode)));
    EXPECT_EQ(file.mesh.triangles.size(), 2u);
    EXPECT_NEAR(area_up(file), 1, 1e-5f) << mode;
  }
  EXPECT_THAT(Refusal("lines.glb", maker.Make(R"({"attributes":{"POSITION":0},"mode":1})")),
              HasSubstr("0 triangles"));
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
      "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 0 1\n1 0 1\n0 0 2\n1 0 2\n";
  EXPECT_NEAR(area_up(Read("strip.ply", ply + "6 0 1 2 3 4 5\n")), 2, 1e-5f);
  const MeshFile two = Read("two.ply", ply + "9 0 1 2 3 -1 2 3 4 5\n");
  EXPECT_EQ(two.mesh.triangles.size(), 4u);
  EXPECT_NEAR(area_up(two), 2, 1e-5f);
}

TEST_F(MeshReadersTest, NormalsThatAreMissingAreFlatAtEdges) {
  const auto directions = [](const MeshFile& file) {
    std::set<std::array<int, 3>> seen;
    for (const Vec3f& n : file.mesh.normals) {
      seen.insert({static_cast<int>(std::lround(100 * n.x())),
                   static_cast<int>(std::lround(100 * n.y())),
                   static_cast<int>(std::lround(100 * n.z()))});
    }
    return seen.size();
  };
  EXPECT_EQ(directions(Read("box.obj", ObjBox(1, 2, 3))), 6u);
  EXPECT_EQ(directions(Read("box.ply", test::PlyBox(1, 2, 3))), 6u);
  EXPECT_EQ(directions(Read("box.glb", GlbBox(1, 2, 3))), 6u);
  // A drum of 24 sides: smooth around, with an edge to its lids; flat where glTF says so.
  std::string obj, drum;
  for (int i = 0; i < 24; ++i) {
    const double a = i * std::numbers::pi / 12;
    for (const int y : {0, 1}) {
      obj += fmt::format("v {:.6f} {} {:.6f}\n", std::cos(a), y, -std::sin(a));
    }
    const int j = (i + 1) % 24;
    drum += fmt::format("f {} {} {} {}\n", 2 * i + 1, 2 * j + 1, 2 * j + 2, 2 * i + 2);
  }
  std::string top = "f", bottom = "f";
  for (int i = 0; i < 24; ++i) {
    top += fmt::format(" {}", 2 * i + 2);
    bottom += fmt::format(" {}", 2 * (23 - i) + 1);
  }
  const MeshFile file = Read("drum.obj", obj + drum + top + "\n" + bottom + "\n");
  EXPECT_EQ(directions(file), 26u) << "one for each place around, and two lids";
  EXPECT_FALSE(file.mesh.slots[0].sheet);
  for (size_t i = 0; i < file.mesh.normals.size(); ++i) {
    const Vec3f& n = file.mesh.normals[i];
    if (std::abs(n.z()) > 0.5f) continue;
    const Vec3f& at = file.mesh.positions[i];
    EXPECT_GT(n.dot(Vec3f(at.x(), at.y(), 0).normalized()), 0.999f);
  }
}

TEST_F(MeshReadersTest, NormalsWithoutADirectionBecomeThoseOfTheirTriangles) {
  const MeshFile file = Read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n");
  for (const Vec3f& n : file.mesh.normals) EXPECT_NEAR(n.y(), 1, 1e-5f);
}

TEST_F(MeshReadersTest, VerticesOfNoTriangleMayHaveNoPlace) {
  // Two triangles at a small angle, each with corners of its own.
  const MeshFile file =
      Read("scan.ply",
           "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\n"
           "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
           "0 0 0\n1 0 0\n0 1 0\nnan nan nan\n1 0 0\n1 1 0.1\n0 1 0\n3 0 1 2\n3 4 5 6\n");
  int shared = 0;
  for (size_t i = 0; i < file.mesh.positions.size(); ++i) {
    for (size_t k = 0; k < i; ++k) {
      if (file.mesh.positions[i] != file.mesh.positions[k]) continue;
      ++shared;
      EXPECT_GT(file.mesh.normals[i].dot(file.mesh.normals[k]), 0.9999f) << "smooth";
    }
  }
  EXPECT_EQ(shared, 2);
}

TEST_F(MeshReadersTest, PlacesFarFromTheOriginKeepTheirDigits) {
  std::string obj, ply =
                       "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\n"
                       "property double y\nproperty double z\nelement face 12\n"
                       "property list uchar int vertex_indices\nend_header\n";
  const std::string box = ObjBox(1, 1, 1), plybox = test::PlyBox(1, 1, 1);
  for (int i = 0; i < 8; ++i) {
    const double x = 500123.4 + 0.8125 * (i & 1), y = 313.2 + 0.3125 * (i >> 1 & 1),
                 z = 4649876.2 + 0.1875 * (i >> 2);
    obj += fmt::format("v {:.4f} {:.4f} {:.4f}\n", x, y, z);
    ply += fmt::format("{:.4f} {:.4f} {:.4f}\n", x, -z, y);
  }
  obj += box.substr(box.find("f "));
  ply += plybox.substr(plybox.find("3 0 4 6"));
  for (const MeshFile& file : {Read("far.obj", obj), Read("far.ply", ply)}) {
    EXPECT_TRUE(file.mesh.Bounds().sizes().isApprox(Vec3f(0.8125f, 0.1875f, 0.3125f), 1e-6f))
        << file.mesh.Bounds().sizes();
    EXPECT_THAT(file.left_out, IsEmpty());
  }
  const std::string moved =
      GlbWith(GlbBox(1, 1, 1), R"({"mesh":0})", R"({"mesh":0,"translation":[500000,0,4649876]})");
  EXPECT_THAT(Read("moved.glb", moved).left_out, IsEmpty()) << "its node moves it";
  std::vector<float> quad = kQuad;
  for (float& number : quad) number += 4649876;
  GlbMaker maker;
  maker.Add(quad, kFloat, "VEC3");
  maker.Add(test::kQuadCorners, kUnsignedShort, "SCALAR");
  const MeshFile lost = Read("far.glb", maker.Make(R"({"attributes":{"POSITION":0},"indices":1})"));
  EXPECT_THAT(lost.left_out, Contains(HasSubstr("far from its origin")));
}

TEST_F(MeshReadersTest, ObjFilesOfOtherSystemsAreRead) {
  Write("box.mtl", Mtl("paint", "a.png"));
  Write("a.png", Quarters());
  const std::string box = ObjBox(1, 1, 1, "paint");
  std::string crlf;
  for (const char c : box) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const std::string joined = "# joined\nv 0 \\\n 0 0\nv 1,5 0 0\nv 0 +1 0 # last\nf -3 -2 -1\n";
  for (const std::string& text : {"\xef\xbb\xbf" + box, crlf}) {
    const MeshFile file = Read("box.obj", text);
    EXPECT_EQ(file.mesh.triangles.size(), 12u);
    EXPECT_THAT(file.materials[0].maps, testing::ElementsAre("colour a.png"));
    EXPECT_THAT(file.left_out, IsEmpty());
  }
  EXPECT_NEAR(Read("joined.obj", joined).mesh.Bounds().sizes().x(), 1.5f, 1e-5f);
  EXPECT_THAT(Refusal("wide.obj", std::string("\xff\xfev\0 \0", 6)), HasSubstr("UTF-16"));
  EXPECT_THAT(Refusal("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
              HasSubstr("line 4: \"4\": vertex 4, wanted 1 to 3"));
  EXPECT_THAT(Refusal("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/2 3/1\n"),
              HasSubstr("line 5: \"2/2\": texture coordinate 2, wanted 1 to 1"));
}

TEST_F(MeshReadersTest, ConcaveFacesAreFilledOnce) {
  // An arrow's head, a cross of two bars.
  const struct {
    const char* obj;
    float area;
  } cases[] = {{"v 0 0 0\nv 2 -1 0\nv 0 3 0\nv -2 -1 0\nf 1 2 3 4\n", 6},
               {"v 1 0 0\nv 2 0 0\nv 2 1 0\nv 3 1 0\nv 3 2 0\nv 2 2 0\nv 2 3 0\nv 1 3 0\nv 1 2 0\n"
                "v 0 2 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4 5 6 7 8 9 10 11 12\n",
                5}};
  for (const auto& c : cases) {
    const MeshFile file = Read("face.obj", c.obj);
    float area = 0;
    for (const Triangle& t : file.mesh.triangles) {
      const auto& p = file.mesh.positions;
      const Vec3f doubled = (p[t.b] - p[t.a]).cross(p[t.c] - p[t.a]);
      EXPECT_GT(doubled.y(), 0);
      area += 0.5f * doubled.y();
    }
    EXPECT_NEAR(area, c.area, 1e-4f);
  }
}

TEST_F(MeshReadersTest, PicturesAreFoundByNamesOfOtherSystems) {
  Write("maps/wood floor.png", Quarters());
  Write("Tex.PNG", Quarters());
  for (const char* name : {"maps/wood%20floor.png", "maps\\\\wood floor.png", "./Tex.PNG",
                           "tex.png", "MAPS/Wood%20Floor.PNG"}) {
    std::string glb = GlbWith(TexturedQuad(""), R"("bufferView":4,"mimeType":"image/png")",
                              fmt::format(R"("uri":"{}")", name));
    EXPECT_EQ(ColorAt(Read("a.glb", glb), 0.25f, 0.25f), "r") << name;
  }
  for (const char* name : {"maps\\wood floor.png", "maps/wood floor.png  ",
                           "\"maps/wood floor.png\"", "tex.png", "-s 1 1 1 maps\\wood floor.png"}) {
    Write("box.mtl", Mtl("paint", name));
    const MeshFile file = Read("box.obj", ObjBox(1, 1, 1, "paint"));
    EXPECT_EQ(file.materials[0].maps.size(), 1u) << name;
  }
  Write("tex.Png", Quarters());
  Write("box.mtl", Mtl("paint", "tex.png"));
  EXPECT_THAT(Refusal("box.obj", ObjBox(1, 1, 1, "paint")),
              HasSubstr("its picture tex.png: no such file, and 2 that differ in the case"));
  for (const char* name :
       {"/etc/a.png", "../a.png", "C:\\a.png", "..\\a.png", "maps/../../a.png"}) {
    Write("box.mtl", Mtl("paint", name));
    EXPECT_THAT(Refusal("box.obj", ObjBox(1, 1, 1, "paint")), HasSubstr("lies elsewhere")) << name;
  }
  Write("._x.png", Quarters());
  Write("box.mtl", Mtl("paint", "._x.png"));
  EXPECT_THAT(Refusal("box.obj", ObjBox(1, 1, 1, "paint")), HasSubstr("no such file"));
}

TEST_F(MeshReadersTest, MaterialsOfAnObjAreFoundOrSaidToBeMissing) {
  Write("mats/paint.mtl", Mtl("paint", "tex.png"));
  Write("mats/tex.png", Quarters());
  Write("my mats.mtl", "newmtl other\nKd 0.1 0.2 0.3\n");
  std::string obj = ObjBox(1, 1, 1, "paint");
  const auto with = [&](const std::string& libraries) {
    std::string text = obj;
    return text.replace(text.find("mtllib box.mtl"), 14, libraries);
  };
  EXPECT_EQ(Read("box.obj", with("mtllib mats\\paint.mtl")).materials[0].maps.size(), 1u);
  EXPECT_EQ(
      Read("box.obj", with("mtllib my mats.mtl\nmtllib mats/paint.mtl")).materials[0].maps.size(),
      1u);
  EXPECT_EQ(Read("box.obj", with("mtllib none.mtl mats/paint.mtl")).materials[0].maps.size(), 1u);
  const MeshFile missing = Read("box.obj", with("mtllib none.mtl"));
  EXPECT_FALSE(missing.materials[0].looks.has_value());
  EXPECT_THAT(missing.left_out, Contains("none.mtl, which is not there"));
  EXPECT_THAT(missing.left_out, Contains("material paint, which no .mtl has"));
  // A change of it would not change the hash of the mesh.
  Write("paint.txt", "newmtl paint\nKd 0.1 0.2 0.3\n");
  EXPECT_THAT(Refusal("box.obj", with("mtllib paint.txt")),
              HasSubstr("its materials paint.txt are named like none, wanted .mtl"));
}

TEST_F(MeshReadersTest, OptionsOfAnObjsMapsAreHonoured) {
  Write("a.png", Quarters());
  const auto with = [&](const std::string& options) {
    Write("box.mtl", Mtl("paint", options + " a.png") + "map_Ns a.png\nmap_Pr a.png\nd 0.5\n");
    return Read("box.obj", ObjBox(1, 1, 1, "paint"));
  };
  EXPECT_EQ(ColorAt(with("-s 2 1 1"), 0.3f, 0.25f), "g");
  EXPECT_EQ(ColorAt(with("-o 0.5 0.5 0"), 0.25f, 0.25f), "gb");
  EXPECT_EQ(ColorAt(with("-clamp on"), 1.25f, 0.25f), "g");
  EXPECT_EQ(ColorAt(with("-blendu off -bm 1.0"), 1.25f, 0.25f), "r");
  const MeshFile file = with("-mm 0 2");
  EXPECT_THAT(file.left_out,
              testing::ElementsAre("map_ns of material paint", "transparency of material paint",
                                   "-mm of the colour map of material paint"));
  EXPECT_EQ(file.materials[0].looks->roughness.factor, 1) << "its map alone";
}

TEST_F(MeshReadersTest, NumbersOfMaterialsAreFinite) {
  const struct {
    const char *line, *refusal;
  } cases[] = {{"Kd nan nan nan", "box.mtl:2: Kd nan nan nan: wanted three numbers"},
               {"Kd 0.5 0.5 -inf", "box.mtl:2: Kd 0.5 0.5 -inf: wanted three numbers"},
               {"Pr nan", "box.mtl:2: pr nan: wanted a number"}};
  for (const auto& c : cases) {
    Write("box.mtl", fmt::format("newmtl paint\n{}\n", c.line));
    EXPECT_THAT(Refusal("box.obj", ObjBox(1, 1, 1, "paint")), HasSubstr(c.refusal));
  }
  Write("a.png", Quarters());
  Write("box.mtl", Mtl("paint", "-s nan nan 1 a.png"));
  const MeshFile file = Read("box.obj", ObjBox(1, 1, 1, "paint"));
  EXPECT_THAT(file.left_out, Contains("-s of the colour map of material paint"));
  EXPECT_EQ(ColorAt(file, 0.25f, 0.25f), "r");
}

TEST_F(MeshReadersTest, ColourMapsWithoutAColourAreNotDarkened) {
  Write("a.png", Quarters());
  const auto with = [&](const std::string& lines) {
    Write("box.mtl", "newmtl paint\n" + lines);
    return Read("box.obj", ObjBox(1, 1, 1, "paint"));
  };
  EXPECT_EQ(with("map_Kd a.png\n").materials[0].looks->color, Vec3f(1, 1, 1));
  EXPECT_EQ(with("map_Kd a.png\nKd 0.5 0.5 0.5\n").materials[0].looks->color,
            Vec3f(0.5f, 0.5f, 0.5f));
  EXPECT_EQ(with("Ns 1\n").materials[0].looks->color, Vec3f(0.6f, 0.6f, 0.6f));
  EXPECT_EQ(with("Kd 0 0 0\n").materials[0].looks->color, Vec3f(0, 0, 0));
  const MeshFile black = with("Kd 0 0 0\nmap_Kd a.png\n");
  EXPECT_EQ(black.materials[0].looks->color, Vec3f(1, 1, 1));
  EXPECT_THAT(black.left_out, Contains(HasSubstr("Kd 0 0 0 of material paint")));
}

TEST_F(MeshReadersTest, WhatIsNotUsedIsSaid) {
  const std::string glb =
      GlbWith(GlbBox(1, 1, 1), R"({"name":"paint",)",
              R"({"name":"paint","alphaMode":"MASK","emissiveTexture":{"index":0},)"
              R"("extensions":{"KHR_materials_clearcoat":{}},)");
  EXPECT_THAT(
      Read("box.glb", glb).left_out,
      testing::ElementsAre("KHR_materials_clearcoat of material paint",
                           "emissiveTexture of material paint", "transparency of material paint"));
  const auto glowing = [](const char* factor) {
    return GlbWith(GlbBox(1, 1, 1), R"({"name":"paint",)",
                   fmt::format(R"({{"name":"paint","emissiveFactor":{},)", factor));
  };
  EXPECT_THAT(Read("lamp.glb", glowing("[0,0.5,0]")).left_out,
              testing::ElementsAre("emissiveFactor of material paint"));
  EXPECT_THAT(Read("lamp.glb", glowing("[0,0,0]")).left_out, IsEmpty());
  for (const auto& [line, left_out] :
       {std::pair("Ke 0 0 0\n", std::vector<std::string>()),
        {"Ke 0 0.5 0\n", std::vector<std::string>{"emission of material paint"}}}) {
    Write("box.mtl", std::string("newmtl paint\nKd 1 1 1\n") + line);
    EXPECT_EQ(Read("box.obj", ObjBox(1, 1, 1, "paint")).left_out, left_out);
  }
  EXPECT_THAT(Read("lines.obj", ObjBox(1, 1, 1) + "l 1 2\nl 2 3\n").left_out,
              testing::ElementsAre("points and lines (2 times)"));
}

}  // namespace
}  // namespace parallax
