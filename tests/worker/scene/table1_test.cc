// Common random numbers: the recipes of the 13 datasets of Table 1, compared part by part.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "common/config/config.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

// A recipe taken apart so that each part can be compared by itself.
using Parts = std::map<std::string, std::string>;

std::string Lines(const std::map<std::string, std::string>& map) {
  std::string text;
  for (const auto& [key, value] : map) text += key + "=" + value + "\n";
  return text;
}

Parts TakeApart(const v1::Scene& scene) {
  std::map<uint32_t, const v1::SceneMaterial*> materials;
  for (const v1::SceneMaterial& material : scene.materials()) {
    materials[material.index()] = &material;
  }
  // Compares by name, because gaps in one variant's indices must not hide equal objects.
  std::map<std::string, std::string> of_kind[5], bound[5], floating_what;
  for (const v1::SceneObject& object : scene.objects()) {
    v1::SceneObject bare = object;
    bare.clear_materials();
    of_kind[object.role()][object.name()] = bare.SerializeAsString();
    for (const v1::MaterialBinding& binding : object.materials()) {
      const v1::SceneMaterial& material = *materials.at(binding.material_index());
      bound[object.role()][object.name() + "." + binding.slot()] =
          material.material_class() + " " + std::to_string(material.seed());
    }
    if (object.role() == v1::OBJECT_ROLE_FLOATING) {
      floating_what[object.name()] = std::to_string(object.index()) + object.asset_class() +
                                     std::to_string(object.seed()) + " " +
                                     std::to_string(object.world_from_object().scale());
    }
  }
  Parts parts;
  parts["room"] = scene.place().house().rooms(0).SerializeAsString();
  parts["architecture"] = Lines(of_kind[v1::OBJECT_ROLE_ARCHITECTURE]);
  parts["furniture"] = Lines(of_kind[v1::OBJECT_ROLE_FURNITURE]);
  parts["fixtures"] = Lines(of_kind[v1::OBJECT_ROLE_LIGHT_FIXTURE]);
  parts["floating: what"] = Lines(floating_what);
  parts["floating: where"] = Lines(of_kind[v1::OBJECT_ROLE_FLOATING]);
  parts["materials of architecture"] = Lines(bound[v1::OBJECT_ROLE_ARCHITECTURE]);
  parts["materials of furniture"] =
      Lines(bound[v1::OBJECT_ROLE_FURNITURE]) + Lines(bound[v1::OBJECT_ROLE_LIGHT_FIXTURE]);
  parts["materials of floating"] = Lines(bound[v1::OBJECT_ROLE_FLOATING]);
  parts["sky"] = scene.sky().SerializeAsString();
  parts["ceiling removed"] = std::to_string(scene.place().house().ceiling_removed());
  std::map<std::string, std::string> lamps, points;
  double total_w = 0;
  int count = 0;
  for (const v1::Light& light : scene.lights()) {
    if (light.kind() == v1::Light::KIND_MESH) {
      lamps[light.name()] = light.SerializeAsString();
    } else {
      points[light.name()] = light.SerializeAsString();
      total_w += (light.power_w().x() + light.power_w().y() + light.power_w().z()) / 3;
      ++count;
    }
  }
  parts["lamps"] = Lines(lamps);
  parts["point lights: where"] = Lines(points);
  parts["point lights: how many"] =
      std::to_string(count) + " " + std::to_string(std::lround(total_w * 1000));
  std::string rigs, baselines;
  for (v1::Rig rig : scene.rigs()) {
    baselines += std::to_string(rig.baseline_m()) + "\n";
    rig.clear_baseline_m();
    rigs += rig.SerializeAsString();
  }
  parts["rigs"] = rigs;
  parts["baselines"] = baselines;
  return parts;
}

struct Allowed {
  const char* variant;
  std::set<std::string> may;   // Parts that may differ from the default's...
  std::set<std::string> must;  // ... and those that do in one seed at least.
};

// Floating objects stand in the way of lights, so lights may be elsewhere.
const std::set<std::string> kOtherFloating = {"floating: what", "floating: where",
                                              "materials of floating", "point lights: where"};

const Allowed kAllowed[] = {
    {"floating-none", kOtherFloating, {"floating: what", "floating: where"}},
    {"floating-0-10", kOtherFloating, {"floating: what", "floating: where"}},
    {"no-background",
     {"furniture", "materials of furniture", "lamps", "floating: where", "floating: what",
      "materials of floating", "point lights: where"},
     {"furniture"}},
    {"floating-chairs", kOtherFloating, {"floating: what"}},
    {"floating-shelves", kOtherFloating, {"floating: what"}},
    {"floating-bushes", kOtherFloating, {"floating: what"}},
    {"materials-none",
     {"materials of furniture", "materials of floating"},
     {"materials of furniture", "materials of floating"}},
    {"materials-one-diffuse",
     {"materials of furniture", "materials of floating"},
     {"materials of furniture", "materials of floating"}},
    {"materials-metal-glass",
     {"materials of furniture", "materials of floating"},
     {"materials of furniture", "materials of floating"}},
    {"baseline-narrow", {"baselines"}, {"baselines"}},
    {"baseline-wide", {"baselines"}, {"baselines"}},
    // A removed ceiling takes its lamps along; the rooms' own things stay.
    {"lighting-realistic",
     {"point lights: how many", "point lights: where", "lamps", "ceiling removed", "architecture",
      "fixtures", "materials of architecture", "materials of furniture"},
     {"point lights: how many"}},
};

class Table1 : public ::testing::Test {
 protected:
  // All variants of a seed; the layout is solved once.
  static std::map<std::string, v1::Scene> Solved(uint64_t seed) {
    const v1::StudySpec study = LoadStudy("table1").value();
    std::map<std::string, v1::Scene> scenes;
    v1::SolveJob job;
    job.set_scene_seed(seed);
    for (const v1::VariantSpec& variant : study.variants()) {
      *job.mutable_config() = variant.config();
      job.mutable_config()->mutable_rigs()->set_count(4);
      const auto result = Solve(job, CancelToken());
      EXPECT_TRUE(result.ok() && result->has_scene()) << variant.name();
      if (!result.ok() || !result->has_scene()) continue;
      if (!job.has_layout()) *job.mutable_layout() = result->layout();
      scenes[variant.name()] = result->scene();
    }
    return scenes;
  }
};

TEST_F(Table1, VariantsOfASeedDifferOnlyWhereTheyMust) {
  std::map<std::string, std::set<std::string>> differed;
  for (const uint64_t seed : {3, 8}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const std::map<std::string, v1::Scene> scenes = Solved(seed);
    ASSERT_EQ(scenes.size(), 13u);
    const Parts base = TakeApart(scenes.at("default"));
    for (const Allowed& allowed : kAllowed) {
      const Parts parts = TakeApart(scenes.at(allowed.variant));
      for (const auto& [name, value] : parts) {
        if (value == base.at(name)) continue;
        differed[allowed.variant].insert(name);
        EXPECT_TRUE(allowed.may.contains(name)) << allowed.variant << " differs in " << name;
      }
    }

    // Fewer floating objects are the first ones of many.
    std::map<uint32_t, std::string> many;
    for (const v1::SceneObject& object : scenes.at("default").objects()) {
      v1::SceneObject bare = object;
      bare.clear_materials();
      many[object.index()] = bare.SerializeAsString();
    }
    for (const v1::SceneObject& object : scenes.at("floating-0-10").objects()) {
      v1::SceneObject bare = object;
      bare.clear_materials();
      EXPECT_EQ(bare.SerializeAsString(), many[object.index()]) << object.name();
    }
    // Each pair's baseline is the same quantile of its range.
    for (int i = 0; i < scenes.at("default").rigs_size(); ++i) {
      const double u = (scenes.at("default").rigs(i).baseline_m() - 0.04) / 0.36;
      EXPECT_NEAR((scenes.at("baseline-wide").rigs(i).baseline_m() - 0.2) / 0.1, u, 1e-9);
    }
  }
  for (const Allowed& allowed : kAllowed) {
    for (const std::string& part : allowed.must) {
      EXPECT_TRUE(differed[allowed.variant].contains(part))
          << allowed.variant << " never differs in " << part;
    }
  }
}

TEST_F(Table1, EachSettingIsWhatThePaperSays) {
  const std::map<std::string, v1::Scene> scenes = Solved(5);
  const auto floating = [&](const std::string& variant) {
    std::vector<v1::SceneObject> found;
    for (const v1::SceneObject& object : scenes.at(variant).objects()) {
      if (object.role() == v1::OBJECT_ROLE_FLOATING) found.push_back(object);
    }
    return found;
  };
  const auto count_role = [&](const std::string& variant, v1::ObjectRole role) {
    const auto& objects = scenes.at(variant).objects();
    return std::count_if(objects.begin(), objects.end(),
                         [&](const auto& object) { return object.role() == role; });
  };
  EXPECT_GE(floating("default").size(), 10u);
  EXPECT_LE(floating("default").size(), 30u);
  EXPECT_LE(floating("floating-0-10").size(), 10u);
  EXPECT_EQ(floating("floating-none").size(), 0u);
  EXPECT_GT(count_role("default", v1::OBJECT_ROLE_FURNITURE), 3);
  EXPECT_EQ(count_role("no-background", v1::OBJECT_ROLE_FURNITURE), 0);
  EXPECT_EQ(count_role("no-background", v1::OBJECT_ROLE_LIGHT_FIXTURE) == 0,
            count_role("default", v1::OBJECT_ROLE_LIGHT_FIXTURE) == 0);
  const std::map<std::string, std::set<std::string>> classes = {
      {"floating-chairs", {"ArmChair", "BarChair", "Chair", "OfficeChair"}},
      {"floating-shelves", {"CellShelf", "LargeShelf", "SimpleBookcase", "TriangleShelf"}},
      {"floating-bushes", {"Bush"}}};
  for (const auto& [variant, names] : classes) {
    EXPECT_GE(floating(variant).size(), 8u) << variant;
    for (const auto& object : floating(variant)) EXPECT_TRUE(names.contains(object.asset_class()));
  }
  const auto material_classes = [&](const std::string& variant) {
    std::map<uint32_t, std::string> by_index;
    for (const auto& m : scenes.at(variant).materials()) by_index[m.index()] = m.material_class();
    std::set<std::string> found;
    for (const v1::SceneObject& object : scenes.at(variant).objects()) {
      if (object.role() != v1::OBJECT_ROLE_FLOATING) continue;
      for (const auto& binding : object.materials())
        found.insert(by_index[binding.material_index()]);
    }
    return found;
  };
  const std::set<std::string> none = material_classes("materials-none");
  EXPECT_TRUE(none.contains("PlainGrey"));
  EXPECT_GT(material_classes("default").size(), 8u);
  for (const v1::Rig& rig : scenes.at("baseline-narrow").rigs()) {
    EXPECT_GE(rig.baseline_m(), 0.04);
    EXPECT_LE(rig.baseline_m(), 0.1);
  }
  for (const v1::Light& light : scenes.at("lighting-realistic").lights()) {
    EXPECT_EQ(light.kind(), v1::Light::KIND_MESH);
  }
}

}  // namespace
}  // namespace parallax
