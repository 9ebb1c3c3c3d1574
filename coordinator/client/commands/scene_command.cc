// scene: recipes, read by people and by other programs.
#include <google/protobuf/text_format.h>
#include <google/protobuf/util/json_util.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/status.h"
#include "coordinator/client/command.h"
#include "coordinator/client/scene_source.h"
#include "coordinator/client/views/scene_text.h"
#include "coordinator/client/views/text.h"
#include "worker/dataset/export/gltf_export.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/types/scene_types.h"

namespace parallax::client {
namespace {

struct SceneOptions {
  std::vector<std::string> source;  // As LoadScene takes it.
  std::string out;
  bool textproto = false;
};

// World extents of all objects, from their regenerated meshes.
absl::StatusOr<std::map<uint32_t, Extent>> ExtentsOf(const v1::Scene& scene) {
  ASSIGN_OR_RETURN(const SceneGeometry geometry, BuildSceneGeometry(scene));
  std::map<uint32_t, Extent> extents;
  for (const PlacedMesh& placed : geometry.meshes) {
    Box3f box;
    for (const Vec3f& position : placed.mesh->positions) {
      box.extend(placed.world_from_object * position);
    }
    if (box.isEmpty()) continue;
    extents[placed.object_index] = {box.min().x(), box.min().y(), box.min().z(),
                                    box.max().x(), box.max().y(), box.max().z()};
  }
  return extents;
}

absl::StatusOr<ExitCode> Show(const SceneOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const v1::Scene scene, LoadScene(options.source, session));
  std::string text;
  if (session.options.json) {
    google::protobuf::util::JsonPrintOptions json;
    json.preserve_proto_field_names = true;
    json.add_whitespace = true;
    if (!google::protobuf::util::MessageToJsonString(scene, &text, json).ok()) {
      return Internal("the recipe can't be written as JSON");
    }
    *session.out().stream << text;
    return kExitOk;
  }
  if (options.textproto) {
    google::protobuf::TextFormat::PrintToString(scene, &text);
    *session.out().stream << text;
    return kExitOk;
  }
  RETURN_IF_ERROR(PrintRecipe(scene, session));
  return kExitOk;
}

absl::StatusOr<ExitCode> Export(const SceneOptions& options, Session& session) {
  ASSIGN_OR_RETURN(const v1::Scene scene, LoadScene(options.source, session));
  ASSIGN_OR_RETURN(const GltfContents contents, ExportGltf(scene, options.out));
  std::error_code error;
  const auto bytes = static_cast<double>(std::filesystem::file_size(options.out, error));
  if (session.options.json) {
    return session.PrintJson({{"file", options.out},
                              {"bytes", bytes},
                              {"objects", scene.objects_size()},
                              {"instances", contents.instances},
                              {"prototypes", contents.prototypes},
                              {"triangles", contents.triangles},
                              {"cameras", 2 * scene.rigs_size()}});
  }
  *session.out().stream << options.out << "\n" << std::flush;
  std::ostream& err = *session.err().stream;
  err << Plural(scene.objects_size(), "object") << ", ";
  if (contents.instances > 0) {
    err << Plural(contents.instances, "instance") << " of "
        << Plural(contents.prototypes, "prototype") << ", ";
  }
  err << Plural(contents.triangles, "triangle") << ", " << Plural(2 * scene.rigs_size(), "camera")
      << ", " << FormatBytes(bytes) << "\n";
  return kExitOk;
}

void AddSource(CLI::App* command, SceneOptions& options) {
  command
      ->add_option("SOURCE", options.source,
                   "A recipe's file, DIR VARIANT SCENE of a dataset, or STUDY VARIANT SCENE of a "
                   "coordinator")
      ->required()
      ->expected(1, 3);
}

}  // namespace

absl::Status PrintRecipe(const v1::Scene& scene, Session& session) {
  ASSIGN_OR_RETURN(const SceneType* type, TypeOf(scene));
  absl::StatusOr<std::map<uint32_t, Extent>> extents = ExtentsOf(scene);
  if (!extents.ok()) {
    session.PrintNote("no plan and sizes: " + FirstLine(ToStd(extents.status().message())));
    extents = std::map<uint32_t, Extent>();
  }
  SceneDescription description = type->describe(scene);
  if (type->map) {
    for (std::string& line : type->map(scene)) description.lines.push_back(std::move(line));
  }
  PrintScene(session.out(), scene, description, *extents);
  return absl::OkStatus();
}

void RegisterScene(Registry& registry) {
  CLI::App* scene =
      registry.AddCommand(registry.app, "scene", "Show a scene's recipe, or export it as glTF");
  scene->require_subcommand(1);

  auto show_options = std::make_shared<SceneOptions>();
  CLI::App* show =
      registry.AddCommand(*scene, "show", "A recipe as text: plan, objects, lights, rigs, solver",
                          "Examples:\n"
                          "  parallax scene show out/quickstart indoor 0\n"
                          "  parallax scene show out/quickstart/indoor/scenes/000000.pb\n"
                          "  parallax scene show baseline narrow 12\n"
                          "  parallax scene show FILE.pb --json | jq '.objects[].name'\n");
  AddSource(show, *show_options);
  show->add_flag("--textproto", show_options->textproto, "The recipe as protobuf text");
  registry.AddConnectionOptions(show);
  registry.SetAction(show,
                     [show_options](Session& session) { return Show(*show_options, session); });

  auto export_options = std::make_shared<SceneOptions>();
  CLI::App* gltf =
      registry.AddCommand(*scene, "export", "Write a scene as .glb: meshes, lights and all cameras",
                          "Examples:\n"
                          "  parallax scene export out/quickstart indoor 0 --out room.glb\n"
                          "  parallax scene export baseline narrow 12 --out room.glb\n");
  AddSource(gltf, *export_options);
  AddOption(gltf, "-o,--out", "GLB", export_options->out, "The .glb file")->required();
  registry.AddConnectionOptions(gltf);
  registry.SetAction(
      gltf, [export_options](Session& session) { return Export(*export_options, session); });
}

}  // namespace parallax::client
