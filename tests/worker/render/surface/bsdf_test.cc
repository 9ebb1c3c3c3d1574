// Properties that hold for every setting of the principled surface.
#include "worker/render/surface/bsdf.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/base/rng.h"
#include "tests/worker/render/test_scenes.h"

namespace parallax {
namespace {

struct NamedSurface {
  std::string name;
  SurfaceSample surface;
};

std::vector<NamedSurface> Surfaces() {
  std::vector<NamedSurface> all;
  const auto add = [&](const std::string& name, auto change) {
    SurfaceSample s;
    s.base_color = Vec3f(0.8f, 0.6f, 0.4f);
    change(s);
    all.push_back({name, s});
  };
  add("diffuse", [](SurfaceSample& s) { s.specular = 0; });
  add("plastic", [](SurfaceSample& s) { s.roughness = 0.4f; });
  add("white plastic", [](SurfaceSample& s) {
    s.base_color.setOnes();
    s.roughness = 0.6f;
    s.specular = 1;
  });
  add("rough metal", [](SurfaceSample& s) {
    s.metallic = 1;
    s.roughness = 0.8f;
  });
  add("metal", [](SurfaceSample& s) {
    s.metallic = 1;
    s.roughness = 0.35f;
  });
  add("half metal", [](SurfaceSample& s) {
    s.metallic = 0.5f;
    s.roughness = 0.5f;
  });
  add("frosted glass", [](SurfaceSample& s) {
    s.transmission = 1;
    s.roughness = 0.5f;
  });
  add("dense frosted glass", [](SurfaceSample& s) {
    s.transmission = 1;
    s.roughness = 0.4f;
    s.ior = 1.9f;
  });
  add("thin frosted glass", [](SurfaceSample& s) {
    s.transmission = 1;
    s.roughness = 0.5f;
    s.thin_walled = true;
  });
  add("wax", [](SurfaceSample& s) {
    s.transmission = 0.4f;
    s.roughness = 0.6f;
  });
  add("lacquer", [](SurfaceSample& s) {
    s.clearcoat = 1;
    s.clearcoat_roughness = 0.3f;
    s.roughness = 0.7f;
  });
  add("velvet", [](SurfaceSample& s) {
    s.sheen = 1;
    s.roughness = 0.9f;
  });
  add("marble", [](SurfaceSample& s) {
    s.subsurface = 1;
    s.roughness = 0.4f;
  });
  add("soft skin", [](SurfaceSample& s) {
    s.subsurface = 0.5f;
    s.roughness = 0.6f;
    s.sheen = 0.3f;
  });
  add("leaf", [](SurfaceSample& s) {
    s.base_color = {0.1f, 0.2f, 0.05f};
    s.transmitted_color = {0.2f, 0.4f, 0.02f};
    s.subsurface = 0.3f;
    s.roughness = 0.45f;
  });
  add("thin paper", [](SurfaceSample& s) {
    s.base_color = {0.5f, 0.4f, 0.3f};
    s.transmitted_color.setOnes();
    s.roughness = 0.8f;
    s.sheen = 0.4f;
  });
  add("coated metal", [](SurfaceSample& s) {
    s.metallic = 1;
    s.roughness = 0.5f;
    s.clearcoat = 1;
    s.clearcoat_roughness = 0.35f;
  });
  add("coated frosted glass", [](SurfaceSample& s) {
    s.transmission = 1;
    s.roughness = 0.6f;
    s.clearcoat = 0.7f;
    s.clearcoat_roughness = 0.4f;
  });
  add("everything", [](SurfaceSample& s) {
    s.metallic = 0.3f;
    s.subsurface = 0.4f;
    s.transmitted_color = {0.1f, 0.3f, 0.5f};
    s.transmission = 0.3f;
    s.clearcoat = 0.5f;
    s.sheen = 0.7f;
    s.roughness = 0.45f;
    s.clearcoat_roughness = 0.4f;
  });
  return all;
}

Vec3f Outgoing(float cosine) { return DirectionAt(cosine, 0.7f); }

// Reflected and refracted energy by sampling, the straight part included.
Vec3f Albedo(const SurfaceSample& surface, float cosine, bool outside, int samples) {
  Rng rng(SceneSeed{7}, "albedo");
  const Bsdf bsdf(surface, Outgoing(cosine), outside);
  Vec3f sum = Vec3f::Zero();
  for (int i = 0; i < samples; ++i) {
    const float lobe = static_cast<float>(rng.Uniform());
    const Vec2f u(static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform()));
    if (const auto sample = bsdf.Sample(std::min(lobe, 0.9999999f), u)) sum += sample->weight;
  }
  return sum / static_cast<float>(samples);
}

// Eight different surfaces, seen and lit from different sides.
TEST(Bsdf, EightScatterAsEachAlone) {
  const std::vector<NamedSurface> surfaces = Surfaces();
  Rng rng(SceneSeed{11}, "eight");
  const auto uniform = [&] { return static_cast<float>(rng.Uniform()); };
  int sampled = 0;
  for (int round = 0; round < 300; ++round) {
    SurfaceSample8 eight;
    Vec3x8 o, i;
    Mask8 outside;
    Float8 lobe, u, v;
    std::vector<Bsdf> alone;
    for (int lane = 0; lane < kLanes; ++lane) {
      const SurfaceSample& surface =
          surfaces[static_cast<size_t>(round + lane * 7) % surfaces.size()].surface;
      eight.Set(lane, surface);
      o.Set(lane, DirectionAt(0.02f + 0.98f * uniform(), 6 * uniform()));
      i.Set(lane, DirectionAt(2 * uniform() - 1, 6 * uniform()));
      outside[lane] = uniform() < 0.5f ? -1 : 0;
      lobe[lane] = uniform();
      u[lane] = uniform();
      v[lane] = uniform();
      alone.emplace_back(surface, o.Get(lane), outside[lane] != 0);
    }
    const Bsdf8 bsdf(eight, o, outside);
    const BsdfValue8 value = bsdf.Evaluate(i);
    const BsdfDirection8 way = bsdf.Sample(lobe, u, v);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Bsdf& one = alone[static_cast<size_t>(lane)];
      EXPECT_EQ(value.f_cos.Get(lane), one.Evaluate(i.Get(lane)).f_cos);
      EXPECT_EQ(value.pdf[lane], one.Evaluate(i.Get(lane)).pdf);
      EXPECT_EQ(bsdf.Straight().Get(lane), one.Straight());
      const auto sample = one.Sample(lobe[lane], {u[lane], v[lane]});
      if (!sample) continue;
      EXPECT_NE(way.valid[lane], 0);
      EXPECT_EQ(way.direction.Get(lane), sample->direction);
      EXPECT_EQ(way.blur[lane], sample->blur);
      ++sampled;
    }
  }
  EXPECT_GT(sampled, 1500);
}

TEST(Bsdf, WhiteDiffuseReturnsAllEnergy) {
  for (const float cosine : {0.05f, 0.3f, 0.7f, 1.0f}) {
    const Vec3f albedo = Albedo(test::DiffuseSample(Vec3f::Ones()), cosine, true, 1000);
    EXPECT_NEAR(albedo.x(), 1.0f, 1e-4f) << cosine;
  }
}

TEST(Bsdf, WhitePlasticAndWhiteMetalReturnAllEnergy) {
  for (const float metallic : {0.0f, 1.0f}) {
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
      SurfaceSample s;
      s.base_color.setOnes();
      s.metallic = metallic;
      s.roughness = roughness;
      for (const float cosine : {0.2f, 0.6f, 1.0f}) {
        EXPECT_NEAR(Albedo(s, cosine, true, 40000).y(), 1.0f, 0.015f)
            << "metallic " << metallic << " roughness " << roughness << " cosine " << cosine;
      }
    }
  }
}

TEST(Bsdf, WhiteSubsurfaceReturnsAllEnergyAndBrightensTheRim) {
  for (const float specular : {0.0f, 0.5f}) {
    SurfaceSample s = test::DiffuseSample(Vec3f::Ones());
    s.specular = specular;
    s.subsurface = 1;
    for (const float cosine : {0.1f, 0.4f, 0.8f, 1.0f}) {
      EXPECT_NEAR(Albedo(s, cosine, true, 40000).x(), 1.0f, 0.02f) << specular << " " << cosine;
    }
  }
  // Lit and seen along the surface it is brighter than Lambert, head-on about alike.
  SurfaceSample lambert = test::DiffuseSample(Vec3f::Ones());
  SurfaceSample inside = lambert;
  inside.subsurface = 1;
  const auto ratio = [&](float cosine) {
    const Vec3f i = DirectionAt(cosine, 2.0f);
    return Bsdf(inside, Outgoing(cosine), true).Evaluate(i).f_cos.x() /
           Bsdf(lambert, Outgoing(cosine), true).Evaluate(i).f_cos.x();
  };
  EXPECT_GT(ratio(0.1f), 1.5f);
  EXPECT_NEAR(ratio(1.0f), 1.06f, 0.02f);
}

// Single sheets in a white furnace: what is not reflected goes through, whatever the gloss.
TEST(Bsdf, WhiteSheetReturnsAllEnergy) {
  for (const float specular : {0.0f, 0.5f, 1.0f}) {
    for (const float reflected : {0.0f, 0.3f, 0.9f}) {
      SurfaceSample s;
      s.specular = specular;
      s.base_color.setConstant(reflected);
      s.transmitted_color.setConstant(1 - reflected);
      for (const float cosine : {0.1f, 0.5f, 1.0f}) {
        EXPECT_NEAR(Albedo(s, cosine, true, 40000).x(), 1.0f, 0.015f)
            << "specular " << specular << " reflected " << reflected << " cosine " << cosine;
      }
    }
  }
}

TEST(Bsdf, DullSheetsScatterToBothSidesWhatTheyAreTold) {
  SurfaceSample s = test::DiffuseSample({0.1f, 0.2f, 0.05f});
  s.transmitted_color = {0.3f, 0.25f, 0.02f};
  const Bsdf leaf(s, Outgoing(0.4f), true);
  for (const float cosine : {0.05f, 0.5f, 1.0f}) {
    const Vec3f above = leaf.Evaluate(DirectionAt(cosine, 3.0f)).f_cos;
    const Vec3f below = leaf.Evaluate(DirectionAt(-cosine, 3.0f)).f_cos;
    EXPECT_LT((above - s.base_color * (cosine * kInvPi)).norm(), 1e-5f) << cosine;
    EXPECT_LT((below - s.transmitted_color * (cosine * kInvPi)).norm(), 1e-5f) << cosine;
  }
}

// Simple cubature of the value over the sphere.
Vec3f IntegratedAlbedo(const Bsdf& bsdf) {
  constexpr int kCosines = 300, kAngles = 240;
  Vec3d sum = Vec3d::Zero();
  for (int c = 0; c < kCosines; ++c) {
    for (int a = 0; a < kAngles; ++a) {
      const float z = 2 * (static_cast<float>(c) + 0.5f) / kCosines - 1;
      const float phi = 2 * kPi * (static_cast<float>(a) + 0.5f) / kAngles;
      sum += bsdf.Evaluate(DirectionAt(z, phi)).f_cos.cast<double>();
    }
  }
  return (sum * (4 * M_PI / (kCosines * kAngles))).cast<float>();
}

TEST(Bsdf, SamplingReachesAllThatEvaluationPromises) {
  for (const NamedSurface& named : Surfaces()) {
    for (const bool outside : {true, false}) {
      if (!outside && named.surface.transmission == 0) continue;
      const Vec3f wanted = IntegratedAlbedo(Bsdf(named.surface, Outgoing(0.6f), outside));
      const Vec3f seen = Albedo(named.surface, 0.6f, outside, 60000);
      EXPECT_LT((seen - wanted).norm(), 0.015f * wanted.norm()) << named.name << " " << outside;
    }
  }
}

// Each layer by itself reflects what its closed form says.
TEST(Bsdf, SmoothMirrorsReflectTheirFresnel) {
  for (const float cosine : {0.1f, 0.5f, 1.0f}) {
    SurfaceSample metal;
    metal.base_color = Vec3f(1.0f, 0.77f, 0.34f);  // Gold.
    metal.metallic = 1;
    metal.roughness = 0;
    const Vec3f schlick =
        metal.base_color + (Vec3f::Ones() - metal.base_color) * std::pow(1 - cosine, 5.0f);
    EXPECT_LT((Albedo(metal, cosine, true, 4000) - schlick).norm(), 0.01f) << cosine;

    SurfaceSample glass;
    glass.transmission = 1;
    glass.roughness = 0;
    glass.base_color.setOnes();
    for (const bool thin : {false, true}) {
      glass.thin_walled = thin;
      const float r = DielectricFresnel(Splat(cosine), Splat(1.5f))[0];
      const float reflected = thin ? 2 * r / (1 + r) : r;
      Rng rng(SceneSeed{9}, "mirror");
      const Bsdf bsdf(glass, Outgoing(cosine), true);
      int up = 0;
      constexpr int kSamples = 20000;
      for (int i = 0; i < kSamples; ++i) {
        const auto sample = bsdf.Sample(static_cast<float>(rng.Uniform()) * 0.9999999f,
                                        {static_cast<float>(rng.Uniform()), 0.5f});
        up += sample && sample->direction.z() > 0;
      }
      EXPECT_NEAR(up / static_cast<float>(kSamples), reflected, 0.015f) << thin << " " << cosine;
    }
  }
}

TEST(Bsdf, SmoothGlassReturnsAllEnergy) {
  SurfaceSample s;
  s.base_color.setOnes();
  s.transmission = 1;
  s.roughness = 0.05f;
  for (const bool thin : {false, true}) {
    s.thin_walled = thin;
    for (const float cosine : {0.3f, 0.9f}) {
      EXPECT_NEAR(Albedo(s, cosine, true, 20000).x(), 1.0f, 0.01f) << thin << " " << cosine;
      EXPECT_NEAR(Albedo(s, cosine, false, 20000).x(), 1.0f, 0.01f) << thin << " " << cosine;
    }
  }
}

TEST(Bsdf, NoSettingReturnsMoreThanItReceives) {
  Rng rng(SceneSeed{3}, "settings");
  const auto u = [&] { return static_cast<float>(rng.Uniform()); };
  for (int k = 0; k < 150; ++k) {
    SurfaceSample s;
    s.base_color.setOnes();
    const auto extreme = [&] {
      return rng.Bernoulli(0.5) ? u() : static_cast<float>(rng.Bernoulli(0.5));
    };
    s.metallic = extreme();
    s.roughness = u();
    s.specular = extreme();
    s.transmission = extreme();
    s.ior = 1.05f + u();
    s.thin_walled = rng.Bernoulli(0.3);
    s.clearcoat = extreme();
    s.clearcoat_roughness = u();
    s.sheen = extreme();
    s.subsurface = extreme();
    if (rng.Bernoulli(0.4)) {
      s.base_color = {u(), u(), u()};
      s.transmitted_color = {u(), u(), u()};
    }
    const float cosine = 0.03f + 0.97f * u();
    const bool outside = rng.Bernoulli(0.6);
    const Vec3f albedo = Albedo(s, cosine, outside, 20000);
    EXPECT_LE(albedo.maxCoeff(), 1.02f)
        << "metallic " << s.metallic << " roughness " << s.roughness << " specular " << s.specular
        << " transmission " << s.transmission << " ior " << s.ior << " thin " << s.thin_walled
        << " clearcoat " << s.clearcoat << " sheen " << s.sheen << " cosine " << cosine
        << " outside " << outside;
    EXPECT_GE(albedo.minCoeff(), 0.0f);
  }
}

TEST(Bsdf, ReflectionIsReciprocal) {
  Rng rng(SceneSeed{4}, "reciprocity");
  const auto u = [&] { return static_cast<float>(rng.Uniform()); };
  for (const NamedSurface& named : Surfaces()) {
    for (int k = 0; k < 50; ++k) {
      const Vec3f a = DirectionAt(0.05f + 0.95f * u(), 6.28f * u());
      const Vec3f b = DirectionAt(0.05f + 0.95f * u(), 6.28f * u());
      const Vec3f ab = Bsdf(named.surface, a, true).Evaluate(b).f_cos / b.z();
      const Vec3f ba = Bsdf(named.surface, b, true).Evaluate(a).f_cos / a.z();
      EXPECT_LT((ab - ba).norm(), 1e-4f * (1.0f + ab.norm())) << named.name;
    }
  }
}

TEST(Bsdf, RefractionIsReciprocalUpToTheIndexSquared) {
  SurfaceSample s;
  s.transmission = 1;
  s.roughness = 0.5f;
  s.ior = 1.5f;
  Rng rng(SceneSeed{5}, "reciprocity");
  int tried = 0;
  for (int k = 0; k < 400; ++k) {
    const auto u = [&] { return static_cast<float>(rng.Uniform()); };
    const Vec3f a = DirectionAt(0.2f + 0.8f * u(), 6.28f * u());
    Vec3f b = DirectionAt(0.2f + 0.8f * u(), 6.28f * u());
    b.z() = -b.z();
    const float ab = Bsdf(s, a, true).Evaluate(b).f_cos.x() / -b.z();
    // Seen from inside, the frame is turned over.
    const float ba = Bsdf(s, -b, false).Evaluate(-a).f_cos.x() / a.z();
    if (ab <= 1e-6f) continue;
    ++tried;
    EXPECT_NEAR(ab / Square(s.ior), ba, 2e-3f * ba + 1e-6f);
  }
  EXPECT_GT(tried, 50);
}

// Light takes the same way through a sheet from either side.
TEST(Bsdf, PassageThroughSheetsIsReciprocal) {
  Rng rng(SceneSeed{12}, "sheets");
  const auto u = [&] { return static_cast<float>(rng.Uniform()); };
  int sheets = 0;
  for (const NamedSurface& named : Surfaces()) {
    if (named.surface.transmitted_color.isZero() || named.surface.transmission > 0) continue;
    ++sheets;
    for (int k = 0; k < 50; ++k) {
      const Vec3f a = DirectionAt(0.05f + 0.95f * u(), 6.28f * u());
      const Vec3f b = DirectionAt(-0.05f - 0.95f * u(), 6.28f * u());
      const Vec3f turned_a(a.x(), a.y(), -a.z()), turned_b(b.x(), b.y(), -b.z());
      const Vec3f ab = Bsdf(named.surface, a, true).Evaluate(b).f_cos / -b.z();
      // Seen from the other side, the frame is turned over.
      const Vec3f ba = Bsdf(named.surface, turned_b, false).Evaluate(turned_a).f_cos / a.z();
      EXPECT_GT(ab.minCoeff(), 0.0f) << named.name;
      EXPECT_LT((ab - ba).norm(), 1e-4f * (1.0f + ab.norm())) << named.name;
    }
  }
  EXPECT_GE(sheets, 2);
}

// Pearson's test over cells of the sphere: counts of sampled directions against the density's
// integral.
TEST(Bsdf, SamplesFollowTheirDensity) {
  constexpr int kCosines = 20, kAngles = 40, kSamples = 200000, kFine = 12;
  for (const NamedSurface& named : Surfaces()) {
    for (const bool outside : {true, false}) {
      if (!outside && named.surface.transmission == 0) continue;
      const Bsdf bsdf(named.surface, Outgoing(0.6f), outside);
      std::vector<double> seen(kCosines * kAngles), wanted(kCosines * kAngles);
      Rng rng(SceneSeed{6}, named.name);
      for (int i = 0; i < kSamples; ++i) {
        const float lobe = static_cast<float>(rng.Uniform());
        const Vec2f u(static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform()));
        const auto sample = bsdf.Sample(std::min(lobe, 0.9999999f), u);
        if (!sample || sample->straight) continue;
        const Vec3f& d = sample->direction;
        const double phi = std::atan2(d.y(), d.x()) + M_PI;
        const int c = std::clamp(static_cast<int>((d.z() + 1) / 2 * kCosines), 0, kCosines - 1);
        const int a = std::clamp(static_cast<int>(phi / (2 * M_PI) * kAngles), 0, kAngles - 1);
        ++seen[static_cast<size_t>(c * kAngles + a)];
      }
      for (int c = 0; c < kCosines * kFine; ++c) {
        for (int a = 0; a < kAngles * kFine; ++a) {
          const float z = 2 * (static_cast<float>(c) + 0.5f) / (kCosines * kFine) - 1;
          const double phi = 2 * M_PI * (a + 0.5) / (kAngles * kFine) - M_PI;
          const Vec3f d = DirectionAt(z, static_cast<float>(phi));
          const double solid_angle = 4 * M_PI / (kCosines * kFine * kAngles * kFine);
          wanted[static_cast<size_t>(c / kFine * kAngles + a / kFine)] +=
              bsdf.Evaluate(d).pdf * solid_angle * kSamples;
        }
      }
      double statistic = 0, pooled_seen = 0, pooled_wanted = 0;
      int cells = 0;
      for (size_t i = 0; i < seen.size(); ++i) {
        if (wanted[i] < 10) {
          pooled_seen += seen[i];
          pooled_wanted += wanted[i];
          continue;
        }
        statistic += (seen[i] - wanted[i]) * (seen[i] - wanted[i]) / wanted[i];
        ++cells;
      }
      if (pooled_wanted > 10) {
        statistic += (pooled_seen - pooled_wanted) * (pooled_seen - pooled_wanted) / pooled_wanted;
        ++cells;
      }
      // Mean `cells`, deviation sqrt(2 cells); the midpoint rule adds a little.
      EXPECT_LT(statistic, cells + 8 * std::sqrt(2.0 * cells) + 20)
          << named.name << " outside " << outside;
      EXPECT_GT(cells, 20) << named.name;
    }
  }
}

TEST(Bsdf, WeightIsValueOverDensity) {
  Rng rng(SceneSeed{8}, "weights");
  for (const NamedSurface& named : Surfaces()) {
    const Bsdf bsdf(named.surface, Outgoing(0.5f), true);
    for (int i = 0; i < 200; ++i) {
      const float lobe = static_cast<float>(rng.Uniform());
      const Vec2f u(static_cast<float>(rng.Uniform()), static_cast<float>(rng.Uniform()));
      const auto sample = bsdf.Sample(lobe, u);
      if (!sample || sample->straight) continue;
      const BsdfValue value = bsdf.Evaluate(sample->direction);
      EXPECT_NEAR(value.pdf, sample->pdf, 1e-4f * value.pdf);
      EXPECT_LT((value.f_cos / value.pdf - sample->weight).norm(),
                1e-3f * sample->weight.norm() + 1e-6f);
      EXPECT_LT(sample->weight.maxCoeff(), 8.0f) << named.name;
    }
  }
}

// Under the same light from all sides.
TEST(Bsdf, AmbientPartsSumToWhatDirectionsGive) {
  constexpr int kSide = 96;
  for (const NamedSurface& named : Surfaces()) {
    if (named.surface.transmission > 0) continue;
    SurfaceSample8 surface;
    for (int lane = 0; lane < kLanes; ++lane) surface.Set(lane, named.surface);
    for (const float cosine : {0.25f, 0.6f, 0.95f}) {
      const Vec3f o(std::sqrt(1 - cosine * cosine), 0, cosine);
      const Bsdf8 bsdf(surface, Vec3x8(o), ~Mask8{});
      Vec3d above = Vec3d::Zero(), below = Vec3d::Zero();
      for (int a = 0; a < kSide; ++a) {
        for (int b = 0; b < kSide; ++b) {
          const float z = (static_cast<float>(a) + 0.5f) / kSide * 2 - 1;
          const float turn = 6.2831853f * (static_cast<float>(b) + 0.5f) / kSide;
          const float r = std::sqrt(1 - z * z);
          const Vec3f i(r * std::cos(turn), r * std::sin(turn), z);
          const Vec3d light = bsdf.Evaluate(Vec3x8(i)).f_cos.Get(0).cast<double>();
          (z > 0 ? above : below) += light * (4 * M_PI / (kSide * kSide));
        }
      }
      const AmbientParts8 parts = bsdf.Ambient();
      for (int c = 0; c < 3; ++c) {
        const double reflected = static_cast<double>((parts.above + parts.gloss).Get(0)[c]);
        EXPECT_NEAR(reflected, above[c], 0.03 + 0.03 * above[c]) << named.name << " at " << cosine;
        EXPECT_NEAR(static_cast<double>(parts.below.Get(0)[c]), below[c], 0.02)
            << named.name << " at " << cosine;
      }
    }
  }
}

}  // namespace
}  // namespace parallax
