// config biome, config room: what a file of a land or a kind of room says, and how it looks.
#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <cstring>
#include <filesystem>

#include "common/base/status.h"
#include "common/config/config.h"
#include "common/config/files/land_files.h"
#include "common/config/files/room_files.h"
#include "common/image/io.h"
#include "coordinator/client/cancellable.h"
#include "coordinator/client/command.h"
#include "coordinator/client/views/text.h"
#include "coordinator/client/views/text_table.h"
#include "worker/assets/asset.h"
#include "worker/render/renderer.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax::client {
namespace {

struct FileOptions {
  std::string file, out;
  uint64_t seed = 1;
  std::string season;          // The season of a land; empty: any.
  std::vector<double> size_m;  // Width, depth and height of a room; empty: as indoor.yaml draws.
};

// The parts of the ground that a rule asks for: "slope, patches".
std::string PartsOf(const v1::GroundPart& part) {
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  part.GetReflection()->ListFields(part, &fields);
  std::vector<std::string> names;
  for (const auto* field : fields) names.push_back(field->name());
  return names.empty() ? "everywhere" : fmt::format("{}", fmt::join(names, ", "));
}

// "spring, summer, 60 % of scenes"
std::string ConditionsOf(const v1::BiomeLayer& layer) {
  std::vector<std::string> words(layer.when().season().begin(), layer.when().season().end());
  words.insert(words.end(), layer.when().land().begin(), layer.when().land().end());
  words.insert(words.end(), layer.when().chosen().begin(), layer.when().chosen().end());
  if (layer.has_chance()) words.push_back(fmt::format("{:.0f} % of scenes", 100 * layer.chance()));
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string QuantityText(const v1::Quantity& quantity) {
  // The text of a message with it alone: "times: {uniform: [0, 1]}".
  v1::BiomeLayer only;
  *only.mutable_times() = quantity;
  const std::string text = MessageToYaml(only);
  const size_t begin = text.find("times: ") + std::strlen("times: ");
  return text.substr(begin, text.find('\n', begin) - begin);
}

// The built-in config `base` with three small views a scene.
absl::StatusOr<v1::SceneConfig> SmallConfig(const std::string& base) {
  ASSIGN_OR_RETURN(v1::SceneConfig config, LoadSceneConfig(base));
  config.mutable_rigs()->set_count(3);
  config.mutable_rigs()->set_width_px(640);
  config.mutable_rigs()->set_height_px(360);
  config.mutable_render()->set_profile("preview");
  return config;
}

// Scenes of the land alone.
absl::StatusOr<v1::SceneConfig> ConfigOf(const v1::Biome& biome, const FileOptions& options) {
  ASSIGN_OR_RETURN(v1::SceneConfig config, SmallConfig("nature"));
  v1::NatureConfig& nature = *config.mutable_nature();
  v1::OwnBiome& own = *nature.add_own_biomes();
  *own.mutable_biome() = biome;
  own.set_weight(1);
  v1::BiomeWeights& others = *nature.mutable_biomes();
  for (int i = 0; i < others.GetDescriptor()->field_count(); ++i) {
    others.GetReflection()->SetDouble(&others, others.GetDescriptor()->field(i), 0);
  }
  if (!options.season.empty()) {
    nature.clear_seasons();
    nature.add_seasons(options.season);
  }
  nature.mutable_walk()->set_fps(0.25);
  return config;
}

// Rooms of the kind alone, without floating objects and light of a study.
absl::StatusOr<v1::SceneConfig> ConfigOf(const v1::RoomKind& kind, const FileOptions& options) {
  ASSIGN_OR_RETURN(v1::SceneConfig config, SmallConfig("indoor"));
  *config.mutable_room()->add_own_kinds() = kind;
  config.mutable_room()->clear_kinds();
  config.mutable_room()->add_kinds(kind.name());
  if (!options.size_m.empty()) {
    config.mutable_room()->mutable_width_m()->set_constant(options.size_m[0]);
    config.mutable_room()->mutable_depth_m()->set_constant(options.size_m[1]);
    config.mutable_room()->mutable_height_m()->set_constant(options.size_m[2]);
  }
  config.mutable_assets()->clear_exclude();
  config.mutable_floating()->mutable_count()->set_constant(0);
  config.mutable_materials()->set_replace_probability(0);
  config.mutable_lighting()->set_mode(v1::LightingConfig::MODE_REALISTIC);
  return config;
}

absl::StatusOr<v1::Scene> SolveOne(const v1::SceneConfig& config, const FileOptions& options,
                                   const CancelToken& cancel) {
  v1::SolveJob job;
  job.set_scene_seed(options.seed);
  *job.mutable_config() = config;
  ASSIGN_OR_RETURN(v1::SolveResult solved, Solve(job, cancel));
  if (solved.has_scene()) return std::move(*solved.mutable_scene());
  return FailedPrecondition("{}: seed {} has no scene ({}); another --seed may have one",
                            options.file, options.seed, solved.rejected().reason());
}

// Describes a scene of the config and renders its views into the folder `options.out`.
absl::StatusOr<ExitCode> DrawScene(const v1::SceneConfig& config, const FileOptions& options,
                                   Session& session) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) return ErrnoError(error.value(), "can't make the folder " + options.out);
  const CancellableScope interrupt;
  ASSIGN_OR_RETURN(const v1::Scene scene, SolveOne(config, options, interrupt.token()));
  RETURN_IF_ERROR(PrintRecipe(scene, session));
  ASSIGN_OR_RETURN(SceneGeometry geometry, BuildSceneGeometry(scene));
  ASSIGN_OR_RETURN(const auto renderer,
                   Renderer::Create(scene, std::move(geometry), config.render()));
  for (int i = 0; i < scene.rigs_size(); ++i) {
    ASSIGN_OR_RETURN(const StereoFrame frame,
                     renderer->RenderRig(scene.rigs(i), interrupt.token(), {}));
    const std::string file = fmt::format("{}/{}.png", options.out, i);
    RETURN_IF_ERROR(WritePng(file, frame.left.color));
    *session.out().stream << file << "\n" << std::flush;
  }
  return kExitOk;
}

absl::StatusOr<ExitCode> PrintAsJson(const google::protobuf::Message& message,
                                     const FileOptions& options, Session& session) {
  if (!options.out.empty()) return InvalidArgument("--json and --out: allowed is one of them");
  google::protobuf::util::JsonPrintOptions json;
  json.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(message, &text, json).ok()) {
    return Internal("{}: can't be written as JSON", options.file);
  }
  *session.out().stream << text << "\n";
  return kExitOk;
}

// Prints what a land's file was understood as: its ground, and what is scattered on it.
absl::StatusOr<ExitCode> ShowBiome(const FileOptions& options, Session& session) {
  const std::string& file = options.file;
  ASSIGN_OR_RETURN(const v1::Biome biome, LoadBiome(file));
  if (session.options.json) return PrintAsJson(biome, options, session);
  std::ostream& out = *session.out().stream;
  out << file << ": " << session.out().Paint(Tone::kGood, "ok") << ", land " << biome.name()
      << " on the landform " << biome.landform() << ", traced for "
      << (biome.has_trace_times() ? biome.trace_times() : 1) << " times as long as rooms\n";
  Table ground({"ground", "where", "when"});
  for (const v1::BiomeGround& rule : biome.ground()) {
    v1::BiomeLayer conditions;
    *conditions.mutable_when() = rule.when();
    ground.AddRow({rule.material(), PartsOf(rule.where()), ConditionsOf(conditions)});
  }
  ground.Print(session.out(), 2);
  Table layers({"layer", "class", Right("a m2"), "where", "when"});
  for (const v1::BiomeLayer& layer : biome.layers()) {
    const bool trees = !layer.has_class_();
    const std::string kind = layer.has_trees() ? layer.trees() : "young " + layer.saplings();
    layers.AddRow({layer.has_name() ? layer.name() : kind, trees ? kind : layer.class_(),
                   trees ? "" : QuantityText(layer.per_m2()), PartsOf(layer.where()),
                   ConditionsOf(layer)});
  }
  layers.Print(session.out(), 2);
  if (options.out.empty()) return kExitOk;
  ASSIGN_OR_RETURN(const v1::SceneConfig config, ConfigOf(biome, options));
  return DrawScene(config, options, session);
}

// "2 to 4"
std::string CountText(bool given, const v1::CountSpan& count, int most) {
  return given ? fmt::format("{} to {}", count.low(), count.high()) : fmt::format("0 to {}", most);
}

// Notes classes that rooms pass over, though the catalogue lists them.
void NoteClassesThatAreOff(const std::string& group, const auto& classes, const Session& session) {
  for (const std::string& name : classes) {
    const AssetClass* found = FindAssetClass(name);
    if (found == nullptr || found->on_by_default) continue;
    session.PrintNote(
        fmt::format("group {}: {} is off in rooms (parallax catalogue) and left out", group, name));
  }
}

// Prints what a file of a kind of room was understood as.
absl::StatusOr<ExitCode> ShowRoom(const FileOptions& options, Session& session) {
  ASSIGN_OR_RETURN(v1::RoomKind kind, LoadRoomKind(options.file));
  if (session.options.json) return PrintAsJson(kind, options, session);
  *session.out().stream << options.file << ": " << session.out().Paint(Tone::kGood, "ok")
                        << ", kind " << kind.name() << ", built like a "
                        << (kind.has_like() ? kind.like() : "living_room") << ", "
                        << Plural(kind.wishes_size(), "wish", "wishes") << "\n";
  Table furniture({"group", "number", "stands", "of"});
  for (const v1::RoomFurniture& row : kind.furniture()) {
    furniture.AddRow({row.group(), CountText(row.has_count(), row.count(), 1),
                      row.has_stand() ? row.stand() : "against_wall", row.anchor()});
  }
  furniture.Print(session.out(), 2);
  Table things({"bearer", "number", "spread", Right("classes")});
  for (const v1::RoomThings& row : kind.things()) {
    things.AddRow({row.bearer(), CountText(row.has_count(), row.count(), 3),
                   row.has_spread() ? row.spread() : "scatter",
                   std::to_string(row.classes_size())});
  }
  things.Print(session.out(), 2);
  for (const v1::RoomFurniture& row : kind.furniture()) {
    NoteClassesThatAreOff(row.group(), row.classes(), session);
  }
  for (const v1::RoomThings& row : kind.things()) {
    NoteClassesThatAreOff(row.bearer(), row.classes(), session);
  }
  if (options.out.empty()) return kExitOk;
  // Built-in names are taken.
  kind.set_name("own_" + kind.name());
  ASSIGN_OR_RETURN(const v1::SceneConfig config, ConfigOf(kind, options));
  return DrawScene(config, options, session);
}

}  // namespace

void RegisterOwnFiles(Registry& registry, CLI::App& config) {
  const auto add = [&](const char* name, const char* what, const char* examples) {
    auto options = std::make_shared<FileOptions>();
    CLI::App* command = registry.AddCommand(
        config, name, std::string("Show the file of ") + what + ", or its mistakes by line",
        std::string("With --out also a scene of it: described, and three small views in the "
                    "folder.\n\nExamples:\n") +
            examples);
    command
        ->add_option("FILE", options->file,
                     std::string("The file of ") + what + ", or the name of a built-in one")
        ->required();
    AddOption(command, "-o,--out", "DIR", options->out, "The folder for the views");
    command->add_option("--seed", options->seed, "The scene's seed")->capture_default_str();
    registry.AddJsonOption(command);
    return std::pair(command, options);
  };
  const auto [biome, land] =
      add("biome", "a land",
          "  parallax config biome my_heath.yaml\n"
          "  parallax config biome my_heath.yaml --out out/heath\n"
          "  parallax config biome forest --out out/forest --season winter\n");
  biome->add_option("--season", land->season, "Season of the scene (default: a random one)")
      ->check(CLI::IsMember({"spring", "summer", "autumn", "winter"}));
  registry.SetAction(biome,
                     [options = land](Session& session) { return ShowBiome(*options, session); });
  const auto [room, kind] =
      add("room", "a kind of room",
          "  parallax config room workshop.yaml\n"
          "  parallax config room workshop.yaml --out out/workshop --size-m 9 6 3.5\n"
          "  parallax config room office --out out/office --seed 7\n");
  AddOption(room, "--size-m", "METRES", kind->size_m,
            "Width, depth and height (default: random, as in built-in rooms)")
      ->expected(3)
      ->check(CLI::Range(2.1, 12.0));
  registry.SetAction(room,
                     [options = kind](Session& session) { return ShowRoom(*options, session); });
}

}  // namespace parallax::client
