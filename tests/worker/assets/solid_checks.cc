#include "tests/worker/assets/solid_checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "common/base/rng.h"

namespace parallax::test {

Mesh WithoutSheets(const Mesh& mesh) {
  Mesh solid = mesh;
  std::erase_if(solid.triangles, [&](const Triangle& t) { return mesh.slots[t.slot].sheet; });
  return solid;
}

std::vector<uint32_t> Weld(const Mesh& mesh) {
  struct Key {
    std::array<uint32_t, 3> bits;
    uint32_t vertex;
  };
  std::vector<Key> keys(mesh.positions.size());
  for (uint32_t v = 0; v < keys.size(); ++v) {
    const Vec3f plain = mesh.positions[v] + Vec3f::Zero();  // -0 becomes 0.
    std::memcpy(keys[v].bits.data(), plain.data(), sizeof(keys[v].bits));
    keys[v].vertex = v;
  }
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
    return a.bits != b.bits ? a.bits < b.bits : a.vertex < b.vertex;
  });
  std::vector<uint32_t> weld(keys.size());
  for (size_t i = 0; i < keys.size(); ++i) {
    const bool same = i > 0 && keys[i].bits == keys[i - 1].bits;
    weld[keys[i].vertex] = same ? weld[keys[i - 1].vertex] : keys[i].vertex;
  }
  return weld;
}

int OpenEdges(const Mesh& mesh, const std::vector<uint32_t>& weld) {
  // The lower end, the upper end, and in the lowest bit the direction.
  std::vector<std::array<uint32_t, 3>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const uint32_t v[3] = {weld[t.a], weld[t.b], weld[t.c]};
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = v[k], b = v[(k + 1) % 3];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1u : 0u});
    }
  }
  std::sort(edges.begin(), edges.end());
  int open = 0;
  for (size_t i = 0; i < edges.size();) {
    int balance = 0;
    size_t j = i;
    for (; j < edges.size() && edges[j][0] == edges[i][0] && edges[j][1] == edges[i][1]; ++j) {
      balance += edges[j][2] ? 1 : -1;
    }
    open += balance != 0;
    i = j;
  }
  return open;
}

int DegenerateTriangles(const Mesh& mesh, const std::vector<uint32_t>& weld) {
  int degenerate = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3d a = mesh.positions[t.a].cast<double>(), b = mesh.positions[t.b].cast<double>(),
                c = mesh.positions[t.c].cast<double>();
    const bool joined = weld[t.a] == weld[t.b] || weld[t.b] == weld[t.c] || weld[t.c] == weld[t.a];
    degenerate += joined || (b - a).cross(c - a).norm() < 2e-12;
  }
  return degenerate;
}

int UnreferencedVertices(const Mesh& mesh) {
  std::vector<bool> used(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) used[t.a] = used[t.b] = used[t.c] = true;
  return static_cast<int>(std::count(used.begin(), used.end(), false));
}

int UnusedSlots(const Mesh& mesh) {
  std::vector<bool> used(mesh.slots.size());
  for (const Triangle& t : mesh.triangles) used[t.slot] = true;
  return static_cast<int>(std::count(used.begin(), used.end(), false));
}

int InsideOutParts(const Mesh& mesh, const std::vector<uint32_t>& weld) {
  std::vector<uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.triangles) {
    parent[root(weld[t.a])] = root(weld[t.b]);
    parent[root(weld[t.b])] = root(weld[t.c]);
  }
  std::vector<double> volume(mesh.positions.size());
  std::vector<bool> has(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) {
    const uint32_t part = root(weld[t.a]);
    // About a point of the part: cancellation would hide thin ones.
    const Vec3d o = mesh.positions[part].cast<double>();
    const Vec3d a = mesh.positions[t.a].cast<double>() - o,
                b = mesh.positions[t.b].cast<double>() - o,
                c = mesh.positions[t.c].cast<double>() - o;
    volume[part] += a.cross(b).dot(c) / 6;
    has[part] = true;
  }
  int wrong = 0;
  for (size_t part = 0; part < volume.size(); ++part) wrong += has[part] && !(volume[part] > 0);
  return wrong;
}

int WrongLines(const Mesh& mesh, int lines, uint64_t seed) {
  struct Crossing {
    double at;
    int step;
  };
  Rng rng(SceneSeed{seed}, "lines");
  std::vector<Vec3d> points(mesh.positions.size());
  int wrong = 0;
  for (int k = 0; k < lines; ++k) {
    // Through a random point of a random triangle, so that thin things are met too.
    const Triangle& through = rng.Pick(mesh.triangles);
    const double s = rng.Uniform(0.1, 0.45), q = rng.Uniform(0.1, 0.45);
    const Vec3d origin = (1 - s - q) * mesh.positions[through.a].cast<double>() +
                         s * mesh.positions[through.b].cast<double>() +
                         q * mesh.positions[through.c].cast<double>();
    const double dx = rng.Normal(), dy = rng.Normal(), dz = rng.Normal();
    const Eigen::Quaterniond turn =
        Eigen::Quaterniond::FromTwoVectors(Vec3d(dx, dy, dz), Vec3d::UnitZ());
    for (size_t i = 0; i < points.size(); ++i) {
      points[i] = turn * (mesh.positions[i].cast<double>() - origin);
    }
    // The line is now the z axis.
    std::vector<Crossing> crossings;
    bool grazes = false;
    for (const Triangle& t : mesh.triangles) {
      const Vec3d &a = points[t.a], &b = points[t.b], &c = points[t.c];
      const double u = b.x() * c.y() - b.y() * c.x(), v = c.x() * a.y() - c.y() * a.x(),
                   w = a.x() * b.y() - a.y() * b.x();
      if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
      const double sum = u + v + w;
      // Through a corner or along an edge: such a line says nothing.
      if (u == 0 || v == 0 || w == 0) {
        grazes |= sum != 0;
        continue;
      }
      // Counter-clockwise seen along -z: the normal has z > 0, a ray along +z leaves.
      crossings.push_back({(u * a.z() + v * b.z() + w * c.z()) / sum, sum > 0 ? -1 : 1});
    }
    if (grazes) continue;
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
    int inside = 0, before = 0;
    bool bad = false;
    for (size_t i = 0; i < crossings.size(); ++i) {
      inside += crossings[i].step;
      // Faces that touch count together.
      const bool apart = i + 1 == crossings.size() || crossings[i + 1].at - crossings[i].at > 2e-6;
      if (!apart) continue;
      bad |= inside < 0;
      before = inside;
    }
    wrong += bad || before != 0;
  }
  return wrong;
}

Outline OutlineOf(const Mesh& mesh, const Vec3f& extent) {
  Outline outline;
  constexpr int kPlanes[3][2] = {{0, 2}, {1, 2}, {0, 1}};
  const Vec3f center = mesh.Bounds().center();
  const float cell = extent.maxCoeff() / kOutlineCells;
  for (size_t view = 0; view < 3; ++view) {
    const auto [x, y] = kPlanes[view];
    for (const Triangle& t : mesh.triangles) {
      Vec2f p[3];
      for (int k = 0; k < 3; ++k) {
        const Vec3f q = mesh.positions[k == 0 ? t.a : k == 1 ? t.b : t.c] - center;
        p[k] = Vec2f(q[x], q[y]) / cell + Vec2f::Constant(0.5f * kOutlineCells);
      }
      const Vec2f low = p[0].cwiseMin(p[1]).cwiseMin(p[2]),
                  high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
      const int x0 = std::max(0, static_cast<int>(std::ceil(low.x() - 0.5f))),
                x1 = std::min(kOutlineCells - 1, static_cast<int>(std::floor(high.x() - 0.5f)));
      const int y0 = std::max(0, static_cast<int>(std::ceil(low.y() - 0.5f))),
                y1 = std::min(kOutlineCells - 1, static_cast<int>(std::floor(high.y() - 0.5f)));
      const auto side = [](const Vec2f& a, const Vec2f& b, const Vec2f& c) {
        return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
      };
      for (int j = y0; j <= y1; ++j) {
        for (int i = x0; i <= x1; ++i) {
          const Vec2f at(static_cast<float>(i) + 0.5f, static_cast<float>(j) + 0.5f);
          const float u = side(p[0], p[1], at), v = side(p[1], p[2], at), w = side(p[2], p[0], at);
          if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
          outline.set((view * kOutlineCells + static_cast<size_t>(j)) * kOutlineCells +
                      static_cast<size_t>(i));
        }
      }
    }
  }
  return outline;
}

std::string Bytes(const Mesh& mesh) {
  std::string out;
  const auto append = [&](const void* data, size_t size) {
    out.append(static_cast<const char*>(data), size);
  };
  append(mesh.positions.data(), mesh.positions.size() * sizeof(Vec3f));
  append(mesh.normals.data(), mesh.normals.size() * sizeof(Vec3f));
  append(mesh.texture.data(), mesh.texture.size() * sizeof(Vec3f));
  append(mesh.uv.data(), mesh.uv.size() * sizeof(Vec2f));
  for (const Triangle& t : mesh.triangles) {
    const std::array<uint32_t, 4> words{t.a, t.b, t.c, t.slot};
    append(words.data(), sizeof(words));
  }
  return out;
}

}  // namespace parallax::test
