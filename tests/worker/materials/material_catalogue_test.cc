// One suite for every material of the catalogue: what the renderer relies on, whatever the family.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>

#include "worker/materials/kernel/material.h"

namespace parallax {
namespace {

constexpr int kSeeds = 4;

std::unique_ptr<const Material> Make(const MaterialClass& c, uint64_t seed) {
  auto made = MakeMaterial(c.name, seed);
  EXPECT_TRUE(made.ok()) << made.status();
  return *std::move(made);
}

// A point on a face of a random body; pictures get their uv.
SurfacePoint RandomPoint(Rng& rng) {
  SurfacePoint point;
  for (int i = 0; i < 3; ++i) point.texture_m[i] = static_cast<float>(rng.Uniform(-6, 6));
  point.normal = Vec3f(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                       static_cast<float>(rng.Normal()))
                     .normalized();
  if (rng.Bernoulli(0.5)) point.texture_normal = point.normal;
  point.uv = Vec2f(static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform()));
  if (rng.Bernoulli(0.7)) {
    point.footprint_m = static_cast<float>(std::exp(rng.Uniform(std::log(1e-4), std::log(0.5))));
  }
  return point;
}

std::vector<float> Values(const SurfaceSample& s) {
  return {s.base_color.x(),
          s.base_color.y(),
          s.base_color.z(),
          s.metallic,
          s.roughness,
          s.specular,
          s.transmission,
          s.ior,
          s.clearcoat,
          s.clearcoat_roughness,
          s.sheen,
          s.opacity,
          s.emission.x(),
          s.emission.y(),
          s.emission.z(),
          s.subsurface,
          s.thin_walled ? 1.0f : 0.0f};
}

float LuminanceOf(const SurfaceSample& s) {
  return 0.2126f * s.base_color.x() + 0.7152f * s.base_color.y() + 0.0722f * s.base_color.z();
}

// The points of a horizontal square patch, jittered, seen with a footprint. uv runs over `uv_size`
// of the picture.
template <typename Visit>
void OverPatch(Rng& rng, float size_m, float uv_size, float footprint_m, int side,
               const Visit& visit) {
  const Vec3f corner(static_cast<float>(rng.Uniform(-3, 3)), static_cast<float>(rng.Uniform(-3, 3)),
                     static_cast<float>(rng.Uniform(-0.5, 0.5)));
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const float x =
          (static_cast<float>(i) + static_cast<float>(rng.Uniform())) / static_cast<float>(side);
      const float y =
          (static_cast<float>(j) + static_cast<float>(rng.Uniform())) / static_cast<float>(side);
      SurfacePoint point;
      point.texture_m = corner + size_m * Vec3f(x, y, 0);
      point.texture_normal = point.normal;
      point.uv = Vec2f(0.5f, 0.5f) + uv_size * Vec2f(x - 0.5f, y - 0.5f);
      point.footprint_m = footprint_m;
      point.footprint_uv = footprint_m / size_m * uv_size;
      visit(point);
    }
  }
}

struct Spread {
  double mean = 0, variance = 0;
};
Spread SpreadOf(const std::vector<double>& values) {
  Spread s;
  for (double v : values) s.mean += v / static_cast<double>(values.size());
  for (double v : values)
    s.variance += (v - s.mean) * (v - s.mean) / static_cast<double>(values.size());
  return s;
}

class EveryMaterial : public testing::TestWithParam<std::string> {
 protected:
  const MaterialClass& material_class() const { return *FindMaterialClass(GetParam()); }
};

std::vector<std::string> AllNames() {
  std::vector<std::string> names;
  for (const MaterialClass& c : MaterialCatalogue()) names.push_back(c.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryMaterial, testing::ValuesIn(AllNames()),
                         [](const auto& info) { return info.param; });

TEST_P(EveryMaterial, SameSeedGivesTheSameBytes) {
  const auto first = Make(material_class(), 7), again = Make(material_class(), 7);
  Rng rng(SceneSeed{1}, "points");
  for (int i = 0; i < 300; ++i) {
    const SurfacePoint point = RandomPoint(rng);
    const std::vector<float> a = Values(first->Evaluate(point)), b = Values(again->Evaluate(point));
    ASSERT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0);
    ASSERT_EQ(first->Height(point), again->Height(point));
  }
}

// Eight points in lanes get what each gets alone, near one another or far apart.
TEST_P(EveryMaterial, EightPointsGetWhatEachGetsAlone) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto material = Make(material_class(), seed);
    Rng rng(SceneSeed{8}, "points");
    for (int i = 0; i < 60; ++i) {
      std::vector<SurfacePoint> points(static_cast<size_t>(1 + i % kLanes), RandomPoint(rng));
      for (SurfacePoint& point : points) {
        if (i % 2 == 0) point = RandomPoint(rng);
        point.texture_m.x() += static_cast<float>(rng.Uniform(0, 0.02));
        point.footprint_m *= static_cast<float>(rng.Uniform(0.5, 2));
      }
      const SurfacePoint8 eight(points);
      const SurfaceSample8 samples = material->Evaluate(eight);
      const Float8 heights = material->Height(eight);
      for (size_t k = 0; k < points.size(); ++k) {
        const int lane = static_cast<int>(k);
        ASSERT_EQ(Values(samples.Get(lane)), Values(material->Evaluate(points[k])));
        ASSERT_EQ(heights[lane], material->Height(points[k]));
      }
    }
  }
}

TEST_P(EveryMaterial, SeedsDiffer) {
  std::set<std::vector<float>> looks;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const auto material = Make(material_class(), seed);
    Rng rng(SceneSeed{2}, "points");
    std::vector<float> look;
    for (int i = 0; i < 8; ++i) {
      for (float v : Values(material->Evaluate(RandomPoint(rng)))) look.push_back(v);
    }
    looks.insert(look);
  }
  if (GetParam() == "PlainGrey") {
    EXPECT_EQ(looks.size(), 1u) << "the study's one grey";
  } else {
    EXPECT_GE(looks.size(), 11u);
  }
}

TEST_P(EveryMaterial, ValuesAreFiniteAndInRange) {
  Rng rng(SceneSeed{3}, "points");
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const auto material = Make(material_class(), seed);
    for (int i = 0; i < 1200; ++i) {
      const SurfacePoint point = RandomPoint(rng);
      const SurfaceSample s = material->Evaluate(point);
      for (float v : Values(s)) ASSERT_TRUE(std::isfinite(v));
      for (int c = 0; c < 3; ++c) {
        ASSERT_GE(s.base_color[c], 0.0199f);
        ASSERT_LE(s.base_color[c], 0.9001f);
        ASSERT_GE(s.emission[c], 0.0f);
        if (material_class().family != "emissive" && !material_class().tags.needs_uv) {
          ASSERT_EQ(s.emission[c], 0.0f);
        }
      }
      for (float v : {s.metallic, s.roughness, s.specular, s.transmission, s.clearcoat,
                      s.clearcoat_roughness, s.sheen, s.opacity}) {
        ASSERT_GE(v, 0.0f);
        ASSERT_LE(v, 1.0f);
      }
      ASSERT_GE(s.ior, 1.0f);
      ASSERT_LE(s.ior, 2.5f);
      const float height = material->Height(point);
      ASSERT_TRUE(std::isfinite(height));
      // Relief that is seen from far away, the blocks of rock, is higher.
      const float widest_m = material->widest_relief_m();
      ASSERT_LE(std::fabs(height), widest_m > 0.1f ? 0.4f * widest_m : 0.02f);
    }
  }
}

// Over a hand's breadth, pixels of 2 mm must not all have one colour, nor may the relief at 0.2 mm
// be flat; unless the class says that it is smooth: then they must.
TEST_P(EveryMaterial, HasDetailWithinTenCentimetres) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto material = Make(material_class(), seed);
    Rng rng(SceneSeed{4}, "patch");
    double colour = 0, relief = 0;
    for (int patch = 0; patch < 6; ++patch) {
      std::vector<double> luminance, height;
      OverPatch(rng, 0.1f, 1.0f, 1e-3f, 32, [&](const SurfacePoint& p) {
        luminance.push_back(LuminanceOf(material->Evaluate(p)));
      });
      OverPatch(rng, 0.1f, 1.0f, 1e-4f, 32,
                [&](const SurfacePoint& p) { height.push_back(material->Height(p)); });
      const Spread c = SpreadOf(luminance);
      colour += std::sqrt(c.variance) / c.mean / 6;
      relief += std::sqrt(SpreadOf(height).variance) / 6;
    }
    EXPECT_EQ(colour > 0.012 || relief > 4e-6, !material_class().tags.smooth)
        << "seed " << seed << ": relative luminance deviation " << colour << ", relief deviation "
        << relief * 1e6 << " um";
  }
}

TEST_P(EveryMaterial, DetailFadesWithTheFootprintToItsMean) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto material = Make(material_class(), seed);
    double variance[3] = {}, mean[3] = {}, relief[3] = {};
    const float footprints[3] = {0.0f, 0.03f, 3.0f};
    for (int f = 0; f < 3; ++f) {
      Rng rng(SceneSeed{5}, "patch");
      for (int patch = 0; patch < 8; ++patch) {
        std::vector<double> luminance, height;
        OverPatch(rng, 1.0f, 1.0f, footprints[f], 24, [&](const SurfacePoint& p) {
          luminance.push_back(LuminanceOf(material->Evaluate(p)));
          height.push_back(material->Height(p));
        });
        const Spread c = SpreadOf(luminance);
        mean[f] += c.mean / 8;
        variance[f] += c.variance / 8;
        relief[f] += SpreadOf(height).variance / 8;
      }
    }
    EXPECT_LE(variance[1], 1.02 * variance[0] + 1e-9) << "seed " << seed;
    EXPECT_LE(relief[1], 1.02 * relief[0] + 1e-16) << "seed " << seed;
    // At three metres, less than a fortieth of the deviation (or one part in 300 of the colour) is
    // left.
    // Beds of rock are thicker than three metres: a border that a patch happens to have stays.
    const double beds = material_class().name == "RedStrata" ? 0.03 * mean[0] : 0;
    EXPECT_LE(std::sqrt(variance[2]), 0.025 * std::sqrt(variance[0]) + 0.003 * mean[0] + beds)
        << "seed " << seed;
    EXPECT_LE(std::sqrt(relief[2]), 0.025 * std::sqrt(relief[0]) + 1e-8) << "seed " << seed;
    // Faded detail leaves the colour that the eye averaged before.
    EXPECT_NEAR(mean[1] / mean[0], 1.0, 0.15) << "seed " << seed;
    EXPECT_NEAR(mean[2] / mean[0], 1.0, 0.22) << "seed " << seed;
  }
}

// Relief is a surface: no cliffs. A hundredth of a millimetre never rises more than twice that or
// 12 % of the whole.
TEST_P(EveryMaterial, HeightIsContinuous) {
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto material = Make(material_class(), seed);
    Rng rng(SceneSeed{6}, "walk");
    for (int walk = 0; walk < 12; ++walk) {
      SurfacePoint point = RandomPoint(rng);
      point.texture_m *= 0.2f;  // Near the origin a float resolves the step.
      point.footprint_m = walk % 2 == 0 ? 0.0f : 5e-4f;
      Vec3f step(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                 static_cast<float>(rng.Normal()));
      step *= 1e-5f / step.norm();
      const Vec3f start = point.texture_m;
      std::vector<float> heights;
      for (int i = 0; i < 1500; ++i) {
        point.texture_m = start + step * static_cast<float>(i);
        heights.push_back(material->Height(point));
      }
      const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
      const float relief = *high - *low;
      for (size_t i = 1; i < heights.size(); ++i) {
        ASSERT_LE(std::fabs(heights[i] - heights[i - 1]), std::max(2e-5f, 0.12f * relief))
            << "seed " << seed << " step " << i << " of " << relief * 1e3 << " mm relief";
      }
    }
  }
}

// The slopes that bend the normals are those of the height, but for the few points at a kink; what
// is drawn stroke by stroke takes them from half a footprint further.
TEST_P(EveryMaterial, ReliefHasTheSlopesOfItsHeight) {
  constexpr float kStep = 4e-6f;
  const std::string& family = material_class().family;
  const bool drawn = family == "picture" || family == "wallpaper" || GetParam() == "RugPattern";
  const double share = drawn ? 0.4 : 0.03;
  for (uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto material = Make(material_class(), seed);
    Rng rng(SceneSeed{9}, "slopes");
    double missed = 0, whole = 0;
    for (int i = 0; i < 300; ++i) {
      std::vector<SurfacePoint> some(kLanes);
      Tangents8 tangents{};
      for (int lane = 0; lane < kLanes; ++lane) {
        SurfacePoint& point = some[static_cast<size_t>(lane)] = RandomPoint(rng);
        point.texture_m *= 0.02f;  // Near the origin a float resolves the step.
        point.footprint_m =
            static_cast<float>(std::exp(rng.Uniform(std::log(2e-4), std::log(0.01))));
        for (Vec3x8& tangent : tangents.texture) {
          tangent.Set(lane,
                      Vec3f(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                            static_cast<float>(rng.Normal()))
                          .normalized());
        }
      }
      const SurfacePoint8 points(some);
      const Dual8 relief = material->Relief(points, tangents);
      const Float8 height = material->Height(points);
      const auto moved = [&](int along, float far) {
        SurfacePoint8 there = points;
        there.texture_m = points.texture_m + tangents.texture[along] * far;
        return material->Height(there);
      };
      const Float8 dx = (moved(0, kStep) - moved(0, -kStep)) / (2 * kStep);
      const Float8 dy = (moved(1, kStep) - moved(1, -kStep)) / (2 * kStep);
      for (int lane = 0; lane < kLanes; ++lane) {
        // Beyond 2 cm a float resolves less.
        ASSERT_NEAR(relief.value[lane], height[lane],
                    std::max(1e-7f, 5e-6f * std::fabs(height[lane])));
        ASSERT_TRUE(std::isfinite(relief.dx[lane]) && std::isfinite(relief.dy[lane]));
        missed += std::fabs(relief.dx[lane] - dx[lane]) + std::fabs(relief.dy[lane] - dy[lane]);
        whole += std::fabs(dx[lane]) + std::fabs(dy[lane]);
      }
    }
    EXPECT_LE(missed, share * whole) << "seed " << seed;
  }
}

// ---- The catalogue itself

TEST(MaterialCatalogue, IsSortedAndNamesAreUnique) {
  const auto names = AllNames();
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  EXPECT_GE(names.size(), 30u);
}

TEST(MaterialCatalogue, UnknownNamesAreAnsweredWithTheNearest) {
  const auto made = MakeMaterial("OkaWood", 1);
  EXPECT_EQ(made.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(made.status().message()), testing::HasSubstr("\"OakWood\""));
  EXPECT_EQ(FindMaterialClass("oakwood"), nullptr);
}

TEST(MaterialCatalogue, FamiliesAreFoundByNameWhateverTheCase) {
  const auto woods = MaterialsOfFamily("Wood");
  EXPECT_GE(woods.size(), 5u);
  for (const MaterialClass* c : woods) EXPECT_EQ(c->family, "wood");
  ASSERT_EQ(MaterialsOfFamily("oakwood").size(), 1u);
  EXPECT_TRUE(MaterialsOfFamily("unobtainium").empty());
}

// Boulders, whose meshes have edges of decimetres, looked like soap without these blocks.
TEST(StrataRock, IsBrokenBelowTheSizeOfABoulder) {
  for (const char* name : {"GreyStrata", "RedStrata"}) {
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
      const auto material = *MakeMaterial(name, seed);
      Rng rng(SceneSeed{seed}, "places");
      double squares = 0;
      constexpr int kPlaces = 400;
      for (int i = 0; i < kPlaces; ++i) {
        SurfacePoint here = RandomPoint(rng), beside = here;
        here.footprint_m = beside.footprint_m = 0.01f;
        beside.texture_m.x() += 0.02f;
        const double slope = (material->Height(beside) - material->Height(here)) / 0.02;
        squares += slope * slope;
      }
      EXPECT_GT(std::sqrt(squares / kPlaces), 0.2) << name << " " << seed;
    }
  }
}

// Sand that lies as steeply as it can slides; the wind's ripples are on what is flatter.
TEST(DesertSand, HasRipplesOnlyWhereItIsNotSteep) {
  const auto made = MakeMaterial("DesertSand", 3);
  ASSERT_TRUE(made.ok()) << made.status();
  const auto relief_m = [&](float normal_z) {
    SurfacePoint point;
    point.normal = Vec3f(std::sqrt(1 - normal_z * normal_z), 0, normal_z);
    float low = 1e9f, high = -1e9f;
    for (float x = 0; x < 0.4f; x += 0.003f) {
      point.texture_m = Vec3f(x, 0.2f, 0);
      const std::array<SurfacePoint, 1> points = {point};
      const float height = (*made)->Height(SurfacePoint8(points))[0];
      low = std::min(low, height);
      high = std::max(high, height);
    }
    return high - low;
  };
  EXPECT_GT(relief_m(1), 2 * relief_m(0.8f));
}

TEST(MaterialCatalogue, TagsOfferEnoughForEachUse) {
  EXPECT_GE(MaterialsTagged(&MaterialTags::walls).size(), 3u);
  EXPECT_GE(MaterialsTagged(&MaterialTags::floor).size(), 4u);
  EXPECT_GE(MaterialsTagged(&MaterialTags::ceiling).size(), 2u);
  EXPECT_GE(MaterialsTagged(&MaterialTags::metal_or_glass).size(), 8u);
  for (const MaterialClass* c : MaterialsTagged(&MaterialTags::diffuse)) {
    for (uint64_t seed = 0; seed < 4; ++seed) {
      const SurfaceSample s = Make(*c, seed)->Evaluate(SurfacePoint());
      EXPECT_EQ(s.metallic, 0.0f) << c->name;
      EXPECT_EQ(s.transmission, 0.0f) << c->name;
    }
  }
  for (const MaterialClass* c : MaterialsTagged(&MaterialTags::metal_or_glass)) {
    EXPECT_THAT(c->family, testing::AnyOf("metal", "glass", "mirror"));
  }
}

}  // namespace
}  // namespace parallax
