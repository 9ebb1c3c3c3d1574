// Errors of wrong files: each names file, line, field, what was seen and what is allowed.
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/config/config.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

struct BadRow {
  const char* yaml;
  const char* want;  // The whole message, or its beginning when it ends with "...".
};

void ExpectMessage(const absl::Status& status, const BadRow& row) {
  SCOPED_TRACE(row.yaml);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  const std::string message(ToStd(status.message()));
  std::string want = row.want;
  if (want.size() > 3 && want.substr(want.size() - 3) == "...") {
    want.resize(want.size() - 3);
    EXPECT_EQ(message.substr(0, want.size()), want);
  } else {
    EXPECT_EQ(message, want);
  }
}

TEST(SceneConfigYaml, EachWrongValueNamesLineFieldAndWhatIsAllowed) {
  const BadRow rows[] = {
      // Unknown fields.
      {"rigs:\n  basline_m: 1",
       "f.yaml:2: rigs.basline_m: no such field, did you mean baseline_m? "
       "(allowed: count, baseline_m, altitude_m, ..."},
      {"\n\nzzz: 1", "f.yaml:3: zzz: no such field (allowed: type, room, ..."},
      {"room: {kind: [office]}", "f.yaml:1: room.kind: no such field, did you mean kinds? ..."},
      // Wrong types.
      {"rigs: 3", "f.yaml:1: rigs: 3, allowed is a map of fields"},
      {"rigs:", "f.yaml:1: rigs: nothing, allowed is a map of fields"},
      {"rigs:\n# All else.\ntype: indoor", "f.yaml:1: rigs: nothing, allowed is a map of fields"},
      {"rigs: [1]", "f.yaml:1: rigs: a list, allowed is a map of fields"},
      {"[1, 2]", "f.yaml:1: a list, allowed is a map of fields"},
      {"rigs: {count: many}",
       "f.yaml:1: rigs.count: many is not a whole number, allowed 1 to 1000"},
      {"rigs: {count: \"20\"}",
       "f.yaml:1: rigs.count: \"20\" is not a whole number, allowed 1 to 1000"},
      {"rigs: {count: 2.5}", "f.yaml:1: rigs.count: 2.5 is not a whole number, allowed 1 to 1000"},
      {"rigs: {count: {uniform_int: [1, 2]}}",
       "f.yaml:1: rigs.count: a map is not a whole number, allowed 1 to 1000"},
      {"rigs: {min_distance_m: .nan}",
       "f.yaml:1: rigs.min_distance_m: .nan is not a number, allowed 0 to 5 m"},
      {"rigs: {min_distance_m: nan}",
       "f.yaml:1: rigs.min_distance_m: nan is not a number, allowed 0 to 5 m"},
      {"rigs: {min_distance_m: [1]}",
       "f.yaml:1: rigs.min_distance_m: a list is not a number, allowed 0 to 5 m"},
      {"room: {window_glass: yes}", "f.yaml:1: room.window_glass: yes, allowed is true or false"},
      {"room: {window_glass: \"true\"}",
       "f.yaml:1: room.window_glass: \"true\", allowed is true or false"},
      {"room: {kinds: office}", "f.yaml:1: room.kinds: office, allowed is a list of texts"},
      {"materials: {diffuse_material: [Wood]}",
       "f.yaml:1: materials.diffuse_material: a list, allowed is a text"},
      // Out of range.
      {"rigs: {count: 0}", "f.yaml:1: rigs.count: 0 is out of range, allowed 1 to 1000"},
      {"rigs: {count: 99999999999999999999}",
       "f.yaml:1: rigs.count: 99999999999999999999 is not a whole number, allowed 1 to 1000"},
      {"rigs: {min_distance_m: -0.1}",
       "f.yaml:1: rigs.min_distance_m: -0.1 is out of range, allowed 0 to 5 m"},
      {"rigs: {baseline_m: 3}",
       "f.yaml:1: rigs.baseline_m: 3 is out of range, allowed 0.001 to 2 m"},
      {"rigs: {baseline_m: {uniform: [0.1, 3]}}",
       "f.yaml:1: rigs.baseline_m: reaches from 0.1 to 3, allowed 0.001 to 2 m"},
      {"rigs: {baseline_m: {choice: [0.1, 0]}}",
       "f.yaml:1: rigs.baseline_m: reaches from 0 to 0.1, allowed 0.001 to 2 m"},
      {"rigs: {pitch_deg: {clip_gaussian: [90, 15, 0, 95]}}",
       "f.yaml:1: rigs.pitch_deg: reaches from 0 to 95, allowed 1 to 179 deg"},
      {"room: {width_m: {bernoulli: 0.5}}",
       "f.yaml:1: room.width_m: reaches from 0 to 1, allowed 2 to 12 m"},
      {"materials: {replace_probability: 1.5}",
       "f.yaml:1: materials.replace_probability: 1.5 is out of range, allowed 0 to 1"},
      // Whole numbers.
      {"room: {doors: 1.5}", "f.yaml:1: room.doors: 1.5 is not a whole number, allowed 0 to 4"},
      {"room: {doors: {uniform: [1, 2]}}",
       "f.yaml:1: room.doors: gives fractions, allowed are whole numbers: a number, ..."},
      {"room: {doors: {choice: [1, 1.5]}}",
       "f.yaml:1: room.doors.choice[1]: 1.5 is not a whole number, allowed a whole number"},
      {"room: {doors: {uniform_int: [0, 1.5]}}",
       "f.yaml:1: room.doors.uniform_int[1]: 1.5 is not a whole number, allowed a whole number"},
      // Distributions.
      {"rigs:\n  baseline_m:\n    uniform: [0.3, 0.2]",
       "f.yaml:3: rigs.baseline_m.uniform: low 0.3 is not below high 0.2, allowed is [low, high] "
       "with low < high"},
      {"rigs: {baseline_m: {uniform: [0.3]}}",
       "f.yaml:1: rigs.baseline_m.uniform: a list of 1, allowed is [low, high]"},
      {"rigs: {baseline_m: {uniform: 0.3}}",
       "f.yaml:1: rigs.baseline_m.uniform: 0.3, allowed is [low, high]"},
      {"rigs: {baseline_m: {uniform: [a, 0.3]}}",
       "f.yaml:1: rigs.baseline_m.uniform[0]: a is not a number, allowed a number"},
      {"rigs: {baseline_m: {choice: []}}",
       "f.yaml:1: rigs.baseline_m.choice: a list of 0, allowed is [a, b, ...] with at least one "
       "number"},
      {"rigs: {pitch_deg: {clip_gaussian: [90, 0, 60, 95]}}",
       "f.yaml:1: rigs.pitch_deg.clip_gaussian: std 0, allowed is above 0"},
      {"rigs: {pitch_deg: {clip_gaussian: [90, -1, 60, 95]}}",
       "f.yaml:1: rigs.pitch_deg.clip_gaussian: std -1, allowed is above 0"},
      {"rigs: {pitch_deg: {clip_gaussian: [90, 1, 60, 60]}}",
       "f.yaml:1: rigs.pitch_deg.clip_gaussian: low 60 is not below high 60, ..."},
      {"room: {doors: {bernoulli: 1.5}}",
       "f.yaml:1: room.doors.bernoulli: 1.5 is out of range, allowed 0 to 1"},
      {"rigs: {baseline_m: {unifrom: [0.1, 0.2]}}",
       "f.yaml:1: rigs.baseline_m.unifrom: no such distribution, did you mean uniform?, ..."},
      {"rigs: {baseline_m: {uniform: [0.1, 0.2], choice: [0.1]}}",
       "f.yaml:1: rigs.baseline_m: a map with 2 keys, allowed is a number, ..."},
      {"rigs: {baseline_m: [0.1, 0.2]}",
       "f.yaml:1: rigs.baseline_m: a list, allowed is a number, {uniform: [low, high]}, ..."},
      {"rigs: {baseline_m: wide}",
       "f.yaml:1: rigs.baseline_m: wide is not a number, allowed 0.001 to 2 m"},
      {"rigs: {baseline_m: }", "f.yaml:1: rigs.baseline_m: nothing, allowed is a number, ..."},
      // Closed lists.
      {"type: indor",
       "f.yaml:1: type: indor is not known, did you mean indoor? "
       "(allowed: indoor, dense, nature)"},
      {"floating: {placement: street}",
       "f.yaml:1: floating.placement: street, but that is for scenes of type dense; allowed here "
       "are box and view"},
      {"materials: {mode: 4}",
       "f.yaml:1: materials.mode: 4 is not known (allowed: all, none, one_diffuse, metal_glass)"},
      {"materials: {mode: unspecified}", "f.yaml:1: materials.mode: unspecified is not known ..."},
      {"room: {kinds: [office, garage]}",
       "f.yaml:1: room.kinds[1]: \"garage\" is not known (allowed: bathroom, bedroom, closet, "
       "dining_room, hallway, kitchen, living_room, office)"},
      {"room: {kinds: []}", "f.yaml:1: room.kinds: an empty list, allowed is at least 1 of ..."},
      {"render: {profile: hihg}",
       "f.yaml:1: render.profile: \"hihg\" is not known, did you mean "
       "high? (allowed: preview, default, high, reference)"},
      {"render: {maps: [depth, disparities]}",
       "f.yaml:1: render.maps[1]: \"disparities\" is not known, did you mean disparity? ..."},
      // Structure.
      {"rigs: {count: 1}\nroom: {}\nrigs: {count: 2}", "f.yaml:3: rigs: given twice, allowed once"},
      {"rigs:\n  count: 1\n  count: 2", "f.yaml:3: rigs.count: given twice, allowed once"},
      {"? [a]\n: 1", "f.yaml:1: a list as a key, allowed is a field name"},
      {"type: indoor\nrigs: {count: 1",
       "f.yaml:2: not YAML: a comma or the closing } of {name: value, ...} is missing in this line "
       "or before it"},
      {"room: {kinds: [office", "f.yaml:1: not YAML: a comma or the closing ] of [a, b, ...] ..."},
      {"a\tb:\n\t- c", "f.yaml:2: not YAML: line 2 begins with a tab; indent with spaces"},
      {"rigs:\n  count: 3\n\tbaseline_m: 1",
       "f.yaml:3: not YAML: line 3 begins with a tab; indent with spaces"},
      {"type: [indoor\nrigs:\n\tcount: 3", "f.yaml:2: not YAML: ..."},
      {"type: indoor\n---\ntype: dense", "f.yaml:3: a second YAML document, allowed is one"},
      {", 5", "f.yaml:1: a second YAML document, allowed is one"},
      {"  type: indoor\n , 5", "f.yaml:2: a second YAML document, allowed is one"},
      {"type: *nowhere", "f.yaml:1: not YAML: ..."},
  };
  for (const BadRow& row : rows) ExpectMessage(ParseSceneConfig(row.yaml, "f.yaml").status(), row);
}

TEST(StudyYaml, EachWrongValueNamesLineFieldAndWhatIsAllowed) {
  const BadRow rows[] = {
      {"",
       "s.yaml: nothing, allowed is a map of fields: those of a study (study, pairs, variants) or "
       "of a scene config"},
      {"study: s\npairs: 1\nrigs: {count: 2}\nvariants: [{name: a}]",
       "s.yaml:3: rigs: no field of a study but of its scenes, allowed is set.rigs, "
       "variants[].set.rigs, or the file that `base` names"},
      {"study: s\npairs: 1\nvariants:\n  - name: a\n    rigs: {count: 2}",
       "s.yaml:5: variants[0].rigs: no field of a variant but of its scenes, allowed is "
       "variants[0].set.rigs"},
      {"pairs: 1\nvariants: [{name: a}]", "s.yaml:1: study: missing, allowed is the study's name"},
      {"study: s\nvariants: [{name: a}]", "s.yaml:1: pairs: missing, ..."},
      {"study: s\nvariants: [{name: a, pairs: 4}, {name: b}]", "s.yaml:1: pairs: missing, ..."},
      {"study: s\npairs: 1", "s.yaml:1: variants: missing, ..."},
      {"study: My Study\npairs: 1\nvariants: [{name: a}]",
       "s.yaml:1: study: \"My Study\" can't be a folder's name, ..."},
      {"study: s\npairs: 0\nvariants: [{name: a}]",
       "s.yaml:2: pairs: 0 is out of range, allowed 1 to 100000000"},
      {"study: s\npairs: -3\nvariants: [{name: a}]", "s.yaml:2: pairs: -3 is out of range, ..."},
      {"study: s\npairs: 1\nseed: -1\nvariants: [{name: a}]",
       "s.yaml:3: seed: -1, allowed is a whole number from 0 to 2^64 - 1"},
      {"study: s\npairs: 1\nvariants: []",
       "s.yaml:3: variants: an empty list, allowed is a list of at least one {name, set}"},
      {"study: s\npairs: 1\nvariants: {name: a}", "s.yaml:3: variants: not a list, ..."},
      {"study: s\npairs: 1\nvariants:\n  - set: {}",
       "s.yaml:4: variants[0].name: missing, allowed is a folder's name"},
      {"study: s\npairs: 1\nvariants:\n  - name: a\n  - name: a",
       "s.yaml:5: variants[1].name: \"a\" names another variant too, allowed is a name of its own"},
      {"study: s\npairs: 1\nvariants: [{name: ../a}]",
       "s.yaml:3: variants[0].name: \"../a\" can't be a folder's name, ..."},
      {"study: s\npairs: 1\nvariants: [{name: A}]", "s.yaml:3: variants[0].name: \"A\" can't ..."},
      {"study: s\npairs: 1\nvariants: [{name: -a}]",
       "s.yaml:3: variants[0].name: \"-a\" can't ..."},
      {"study: s\npairs: 1\nvariants: [a]", "s.yaml:3: variants[0]: a, allowed is a map of fields"},
      {"study: s\npairs: 1\nvariants:\n  - name: a\n    sets: {}",
       "s.yaml:5: variants[0].sets: no such field, did you mean set? "
       "(allowed: name, base, pairs, rigs_per_scene, seed, set, config, heldout)"},
      {"study: s\npairs: 1\nvariants:\n  - name: a\n    set:\n      rigs: {baseline_m: 9}",
       "s.yaml:6: variants[0].set.rigs.baseline_m: 9 is out of range, allowed 0.001 to 2 m"},
      {"study: s\npairs: 1\nvariants:\n  - name: a\n    set: {}\n    config: {}",
       "s.yaml:4: variants[0]: both set and config, ..."},
      {"study: s\npairs: 1\nrigs_per_scene: 21\nvariants: [{name: a}]",
       "s.yaml:3: rigs_per_scene: 21 is more than variant \"a\" has, allowed 1 to rigs.count = 20"},
      {"study: s\npairs: 1\nrigs_per_scene: 4\nvariants: [{name: a, set: {rigs: {count: 3}}}]",
       "s.yaml:3: rigs_per_scene: 4 is more than variant \"a\" has, allowed 1 to rigs.count = 3"},
      {"study: s\nbase: nowhere.yaml\npairs: 1\nvariants: [{name: a}]",
       "s.yaml:2: base: nowhere.yaml: no such file, allowed is a path or a built-in name: "
       "dense, indoor, nature, released-dense, released-indoor, street"},
      {"study: s\npairs: 1\nvariants:\n  - {name: a, rigs_per_scene: 21}",
       "s.yaml:4: variants[0].rigs_per_scene: 21 is more than the variant has, allowed 1 to "
       "rigs.count = 20"},
      {"study: s\npairs: 1\nvariants:\n  - {name: a, pairs: 0}",
       "s.yaml:4: variants[0].pairs: 0 is out of range, ..."},
      {"study: s\nbasis: x\npairs: 1\nvariants: [{name: a}]",
       "s.yaml:2: basis: no such field, did you mean base? ..."},
  };
  for (const BadRow& row : rows) ExpectMessage(ParseStudy(row.yaml, "s.yaml").status(), row);
}

TEST(SceneConfigYaml, AllErrorsOfAFileAreToldInOrderUpToTwenty) {
  const absl::Status three =
      ParseSceneConfig("type: x\nrigs: {count: 0}\nrender: {maps: [a]}", "f.yaml").status();
  EXPECT_THAT(std::string(three.message()),
              ::testing::MatchesRegex("f.yaml:1: type: .*\nf.yaml:2: rigs.count: .*\nf.yaml:3: "
                                      "render.maps\\[0\\]: .*"));
  std::string many;
  for (int i = 0; i < 25; ++i) many += "unknown" + std::to_string(i) + ": 1\n";
  const std::string message(ParseSceneConfig(many, "f.yaml").status().message());
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 20);
  EXPECT_THAT(message, HasSubstr("f.yaml:20: unknown19"));
  EXPECT_THAT(message, ::testing::EndsWith("\nand 5 more"));
}

TEST(SceneConfigYaml, WrongStructureDoesNotHideWrongValues) {
  const struct {
    const char* yaml;
    std::vector<const char*> lines;
  } rows[] = {
      // A misspelled field, with a wrong value.
      {"rigs: {basline_m: 9}",
       {"f.yaml:1: rigs.basline_m: no such field", "f.yaml:1: rigs.baseline_m: 9 is out of range"}},
      {"rig:\n  count: 0",
       {"f.yaml:2: rig: no such field, did you mean rigs?", "f.yaml:2: rigs.count: 0 is out of"}},
      {"render: {map: [a]}",
       {"f.yaml:1: render.map: no such field", "f.yaml:1: render.maps[0]: \"a\" is not known"}},
      // Twice, a list where a map is wanted, two documents.
      {"rigs: {count: 2}\nrigs: {count: 0}",
       {"f.yaml:2: rigs: given twice", "f.yaml:2: rigs.count: 0 is out of range"}},
      {"rigs:\n  - count: 0\n  - baseline_m: 9",
       {"f.yaml:2: rigs: a list, allowed is a map of fields", "f.yaml:2: rigs.count: 0 is",
        "f.yaml:3: rigs.baseline_m: 9 is"}},
      {"type: x\n---\nrigs: {}", {"f.yaml:3: a second YAML document", "f.yaml:1: type: x is"}},
      // All numbers of a distribution.
      {"rigs: {baseline_m: {uniform: [a, b]}}",
       {"f.yaml:1: rigs.baseline_m.uniform[0]: a is not a number",
        "f.yaml:1: rigs.baseline_m.uniform[1]: b is not a number"}},
  };
  for (const auto& row : rows) {
    const std::string message(ParseSceneConfig(row.yaml, "f.yaml").status().message());
    EXPECT_EQ(std::count(message.begin(), message.end(), '\n') + 1, row.lines.size()) << message;
    for (const char* line : row.lines) EXPECT_THAT(message, HasSubstr(line)) << row.yaml;
  }
}

TEST(StudyYaml, WrongStructureDoesNotHideWrongValues) {
  const std::string message(ParseStudy("pairs: 0\n"
                                       "variants:\n"
                                       "  narrow:\n"
                                       "    set: {rigs: {count: 0}}\n"
                                       "  wide:\n"
                                       "    sets: {rigs: {count: 5000}}\n",
                                       "s.yaml")
                                .status()
                                .message());
  for (const char* line : {"s.yaml:1: study: missing", "s.yaml:1: pairs: 0 is out of range",
                           "s.yaml:3: variants: not a list", "variants.wide.sets: no such field",
                           "s.yaml:4: variants.narrow.set.rigs.count: 0 is out of range",
                           "s.yaml:6: variants.wide.set.rigs.count: 5000 is out of range"}) {
    EXPECT_THAT(message, HasSubstr(line));
  }
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 5) << message;
}

TEST(SceneConfigYaml, HostileTextIsAnErrorAndNotACrash) {
  EXPECT_FALSE(ParseSceneConfig(std::string(100000, '['), "f.yaml").ok());
  EXPECT_FALSE(ParseSceneConfig(std::string("type: indoor\0", 13), "f.yaml").ok());
  EXPECT_FALSE(ParseSceneConfig(std::string(5 << 20, ' '), "f.yaml").ok());
  std::string laughs = "a0: &a0 [x, x]\n";
  for (int i = 1; i < 40; ++i) {
    laughs += fmt::format("a{0}: &a{0} [*a{1}, *a{1}]\n", i, i - 1);
  }
  EXPECT_FALSE(ParseSceneConfig(laughs + "room: {kinds: *a39}", "f.yaml").ok());
}

}  // namespace
}  // namespace parallax
