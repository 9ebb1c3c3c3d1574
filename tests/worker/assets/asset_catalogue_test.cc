// Properties of every asset class, whatever its seed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "worker/assets/asset.h"

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
    EXPECT_NEAR(c.placement == Placement::kCeiling ? box.max().z() : box.min().z(), 0, 1e-4f);
    if (c.placement == Placement::kGround) {
      // The foot of the stem, which need not be the middle, is within the footprint.
      EXPECT_TRUE(Box3f(box.min() - Vec3f::Constant(1e-4f), box.max()).contains(Vec3f(0, 0, 0)));
      continue;
    }
    EXPECT_NEAR(box.center().x(), 0, 1e-4f);
    if (c.placement == Placement::kOnWall || c.placement == Placement::kOpening) {
      EXPECT_NEAR(box.min().y(), 0, 1e-4f);
    } else {
      EXPECT_NEAR(box.center().y(), 0, 1e-4f);
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
