// Questions about a mesh that tests put to every asset: is it closed, does it face outwards, what
// is its outline. Made for thousands of objects: sorted arrays, no maps.
#pragma once

#include <bitset>
#include <cstdint>
#include <string>
#include <vector>

#include "worker/geometry/mesh.h"

namespace parallax::test {

// The mesh without the triangles of sheets, which are neither closed nor hold anything.
Mesh WithoutSheets(const Mesh& mesh);

// Vertices of equal position become one: the surface without its creases. Index by vertex.
std::vector<uint32_t> Weld(const Mesh& mesh);

// Edges that are not run through as often one way as the other: holes and faces turned round.
int OpenEdges(const Mesh& mesh, const std::vector<uint32_t>& weld);

// Triangles without area: two corners weld to one, or less than 1e-12 m^2.
int DegenerateTriangles(const Mesh& mesh, const std::vector<uint32_t>& weld);

// Vertices that no triangle names, and slots that no triangle has.
int UnreferencedVertices(const Mesh& mesh);
int UnusedSlots(const Mesh& mesh);

// Parts (joined by shared vertices) whose signed volume is not positive.
int InsideOutParts(const Mesh& mesh, const std::vector<uint32_t>& weld);

// Random lines are sent through the mesh: entering adds one, leaving takes one away. Where a line
// is inside of less than nothing, or does not come out, a surface faces the wrong way or is
// missing. How many of `lines` are wrong.
int WrongLines(const Mesh& mesh, int lines, uint64_t seed);

// The outline seen from the front, the side and above, over a frame of `extent` about the
// object's axis, cell by cell.
inline constexpr int kOutlineCells = 128;
using Outline = std::bitset<3 * kOutlineCells * kOutlineCells>;
Outline OutlineOf(const Mesh& mesh, const Vec3f& extent);

// All that a mesh is made of, slots aside.
std::string Bytes(const Mesh& mesh);

}  // namespace parallax::test
