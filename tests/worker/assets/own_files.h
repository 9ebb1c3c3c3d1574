// Files as users bring them: boxes in each format, pictures beside them.
#pragma once

#include <string>

namespace parallax::test {

// Boxes of `x` wide, `y` high and `z` deep as their formats have them (glTF and OBJ: y up, looking
// along +z; PLY: z up, looking along -y), closed unless `faces` leaves some of the 12 triangles
// out.
std::string GlbBox(double x, double y, double z, int faces = 12);
// `material`: the name of a material of "box.mtl"; empty: none, and no coordinates of pictures.
std::string ObjBox(double x, double y, double z, const std::string& material = "");
std::string PlyBox(double x, double y, double z);
// The .ply in binary, with the highest byte first if `big`.
std::string BinaryPlyBox(double x, double y, double z, bool big);
// A .glb with this JSON and these data.
std::string Glb(std::string json, std::string data);
// The .glb with `to` in place of `from`, which its JSON has.
std::string GlbWith(const std::string& glb, const std::string& from, const std::string& to);
// Materials with these names, each showing the picture.
std::string Mtl(const std::string& material, const std::string& picture);

}  // namespace parallax::test
