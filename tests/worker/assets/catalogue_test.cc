// What holds for every asset class, whatever its seed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>
#include <numeric>
#include <set>

#include "worker/assets/asset.h"
#include "worker/assets/size_table.h"

namespace parallax {
namespace {

constexpr int kSeeds = 4;

std::vector<std::string> ClassNames() {
  std::vector<std::string> names;
  for (const AssetClass& c : AssetCatalogue()) names.push_back(c.name);
  return names;
}

class EveryAsset : public testing::TestWithParam<std::string> {
 protected:
  Asset Make(uint64_t seed) const {
    absl::StatusOr<Asset> asset = MakeAsset(GetParam(), seed);
    EXPECT_TRUE(asset.ok()) << asset.status();
    return *std::move(asset);
  }
};

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryAsset, testing::ValuesIn(ClassNames()),
                         [](const auto& info) { return info.param; });

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

// Vertices of equal position become one: the surface without its creases.
std::vector<uint32_t> Weld(const Mesh& mesh) {
  std::map<std::array<uint32_t, 3>, uint32_t> first;
  std::vector<uint32_t> welded;
  for (const Vec3f& p : mesh.positions) {
    std::array<uint32_t, 3> key{};
    const Vec3f plain = p + Vec3f::Zero();  // -0 becomes 0.
    std::memcpy(key.data(), plain.data(), sizeof(key));
    welded.push_back(first.try_emplace(key, static_cast<uint32_t>(first.size())).first->second);
  }
  return welded;
}

TEST_P(EveryAsset, IsAValidMesh) {
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Asset asset = Make(seed);
    EXPECT_TRUE(ValidateMesh(asset.mesh).ok()) << ValidateMesh(asset.mesh) << ", seed " << seed;
    std::set<std::string> names;
    for (const MaterialSlot& slot : asset.mesh.slots) {
      EXPECT_TRUE(names.insert(slot.name).second) << "slot " << slot.name << " occurs twice";
      EXPECT_FALSE(slot.families.empty()) << slot.name;
    }
  }
}

TEST_P(EveryAsset, IsTheSameForTheSameSeedAndAnotherForAnother) {
  const std::string first = Bytes(Make(11).mesh);
  EXPECT_TRUE(first == Bytes(Make(11).mesh));
  EXPECT_FALSE(first == Bytes(Make(12).mesh));
}

TEST_P(EveryAsset, UsesKnownMaterialFamilies) {
  const std::set<std::string> known{"wood",      "fabric", "leather", "metal", "plastic",
                                    "glass",     "mirror", "ceramic", "stone", "paint",
                                    "wallpaper", "paper",  "picture", "leaf",  "bark",
                                    "soil",      "carpet", "emissive"};
  for (const MaterialSlot& slot : Make(3).mesh.slots) {
    for (const std::string& family : slot.families) {
      EXPECT_TRUE(known.contains(family)) << slot.name << ": " << family;
    }
  }
}

// Every edge is run through as often one way as the other: no holes, no face turned round.
TEST_P(EveryAsset, IsClosedAndConsistentlyOriented) {
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Mesh mesh = Make(seed).mesh;
    const std::vector<uint32_t> weld = Weld(mesh);
    std::map<std::pair<uint32_t, uint32_t>, int> balance;
    for (const Triangle& t : mesh.triangles) {
      const uint32_t v[3] = {weld[t.a], weld[t.b], weld[t.c]};
      for (int k = 0; k < 3; ++k) {
        const uint32_t a = v[k], b = v[(k + 1) % 3];
        if (a < b) ++balance[{a, b}];
        if (a > b) --balance[{b, a}];
      }
    }
    int open = 0;
    for (const auto& [edge, count] : balance) open += count != 0;
    EXPECT_EQ(open, 0) << "edges, seed " << seed;
  }
}

TEST_P(EveryAsset, EnclosesAPositiveVolumeInEveryPart) {
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Mesh mesh = Make(seed).mesh;
    const std::vector<uint32_t> weld = Weld(mesh);
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
    std::map<uint32_t, double> volume;
    std::map<uint32_t, Vec3f> origin;  // Near the part: cancellation would hide thin ones.
    std::map<uint32_t, Vec3f> at;
    for (const Triangle& t : mesh.triangles) {
      const uint32_t part = root(weld[t.a]);
      const Vec3d o = origin.try_emplace(part, mesh.positions[t.a]).first->second.cast<double>();
      const Vec3d a = mesh.positions[t.a].cast<double>() - o,
                  b = mesh.positions[t.b].cast<double>() - o,
                  c = mesh.positions[t.c].cast<double>() - o;
      volume[part] += a.cross(b).dot(c) / 6;
      at[part] = mesh.positions[t.a];
    }
    for (const auto& [part, v] : volume) {
      EXPECT_GT(v, 0) << "part at " << at[part].transpose() << ", seed " << seed;
    }
  }
}

// Shading normals look to the same side as the faces.
TEST_P(EveryAsset, HasNormalsThatFaceOutwards) {
  const Mesh mesh = Make(2).mesh;
  int wrong = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3f n = (mesh.positions[t.b] - mesh.positions[t.a])
                        .cross(mesh.positions[t.c] - mesh.positions[t.a]);
    for (uint32_t v : {t.a, t.b, t.c}) wrong += n.dot(mesh.normals[v]) < -0.2f * n.norm();
  }
  EXPECT_LE(wrong, static_cast<int>(mesh.triangles.size() / 200));
}

TEST_P(EveryAsset, StandsWhereItsPlacementSays) {
  const AssetClass& c = *FindAssetClass(GetParam());
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Box3f box = Make(seed).mesh.Bounds();
    EXPECT_NEAR(box.center().x(), 0, 1e-4f);
    if (c.placement == Placement::kOnWall || c.placement == Placement::kOpening) {
      EXPECT_NEAR(box.min().y(), 0, 1e-4f);
    } else {
      EXPECT_NEAR(box.center().y(), 0, 1e-4f);
    }
    EXPECT_NEAR(c.placement == Placement::kCeiling ? box.max().z() : box.min().z(), 0, 1e-4f);
  }
}

TEST_P(EveryAsset, HasRealWorldSize) {
  const SizeRange* range = FindSizeRange(GetParam());
  ASSERT_NE(range, nullptr) << "no row in size_table.h";
  for (uint64_t seed = 1; seed <= 3 * kSeeds; ++seed) {
    const Vec3f size = Make(seed).mesh.Bounds().sizes();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(size[axis], range->least_m[axis]) << "axis " << axis << ", seed " << seed;
      EXPECT_LE(size[axis], range->most_m[axis]) << "axis " << axis << ", seed " << seed;
    }
  }
}

// Heights at which the upright line through a point meets the mesh.
std::vector<float> Crossings(const Mesh& mesh, const Vec2f& at) {
  std::vector<float> out;
  const auto cross = [](const Vec2f& u, const Vec2f& v) { return u.x() * v.y() - u.y() * v.x(); };
  for (const Triangle& t : mesh.triangles) {
    const Vec3f &a = mesh.positions[t.a], &b = mesh.positions[t.b], &c = mesh.positions[t.c];
    const Vec2f p = a.head<2>() - at, q = b.head<2>() - at, r = c.head<2>() - at;
    const float u = cross(q, r), v = cross(r, p), w = cross(p, q), sum = u + v + w;
    if (std::abs(sum) < 1e-12f) continue;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
    out.push_back((u * a.z() + v * b.z() + w * c.z()) / sum);
  }
  return out;
}

// Things can stand on a support: it lies on the object and the room above it is free.
TEST_P(EveryAsset, OffersSupportsThatAreFree) {
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Asset asset = Make(seed);
    const Box3f box = asset.mesh.Bounds();
    for (const SupportSurface& s : asset.supports) {
      EXPECT_GT(s.area.sizes().minCoeff(), 0.02f);
      EXPECT_GT(s.clearance_m, 0.02f);
      EXPECT_GE(s.area.min().x(), box.min().x() - 1e-3f);
      EXPECT_LE(s.area.max().x(), box.max().x() + 1e-3f);
      EXPECT_GE(s.area.min().y(), box.min().y() - 1e-3f);
      EXPECT_LE(s.area.max().y(), box.max().y() + 1e-3f);
      EXPECT_LE(s.z_m, box.max().z() + 1e-3f);
      for (int i = 0; i < 9; ++i) {
        const Vec2f at = s.area.min() + s.area.sizes().cwiseProduct(Vec2f(0.03f + 0.47f * (i % 3),
                                                                          0.03f + 0.47f * (i / 3)));
        bool carried = false, free = true;
        for (const float z : Crossings(asset.mesh, at)) {
          carried |= std::abs(z - s.z_m) < 0.006f;
          free &= z < s.z_m + 0.006f || z > s.z_m + s.clearance_m - 0.004f;
        }
        EXPECT_TRUE(carried) << "nothing at z " << s.z_m << " below " << at.transpose() << ", seed "
                             << seed;
        EXPECT_TRUE(free) << "something above z " << s.z_m << " at " << at.transpose() << ", seed "
                          << seed;
      }
    }
  }
}

TEST_P(EveryAsset, KeepsPicturesInTheUnitSquare) {
  const Mesh mesh = Make(5).mesh;
  for (const Triangle& t : mesh.triangles) {
    const std::vector<std::string>& families = mesh.slots[t.slot].families;
    const bool picture = !families.empty() && families.front() == "picture";
    if (!picture) continue;
    const Vec2f a = mesh.uv[t.a], b = mesh.uv[t.b], c = mesh.uv[t.c];
    for (const Vec2f& uv : {a, b, c}) {
      EXPECT_GE(uv.minCoeff(), -1e-5f);
      EXPECT_LE(uv.maxCoeff(), 1 + 1e-5f);
    }
  }
}

TEST(AssetCatalogue, IsSortedAndFound) {
  const std::vector<AssetClass>& classes = AssetCatalogue();
  for (size_t i = 1; i < classes.size(); ++i) EXPECT_LT(classes[i - 1].name, classes[i].name);
  for (const AssetClass& c : classes) EXPECT_EQ(FindAssetClass(c.name), &c);
  EXPECT_EQ(FindAssetClass("NoSuchThing"), nullptr);
}

TEST(AssetCatalogue, NamesTheNearestClassForAnUnknownOne) {
  const absl::StatusOr<Asset> asset = MakeAsset("ofice chair", 1);
  ASSERT_EQ(asset.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(asset.status().message()), testing::HasSubstr("'OfficeChair'"));
}

}  // namespace
}  // namespace parallax
