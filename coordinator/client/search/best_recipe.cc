#include "coordinator/client/search/best_recipe.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <memory>
#include <utility>
#include <vector>

#include "common/config/check/field_rules.h"
#include "common/config/config.h"
#include "common/config/defaults.h"
#include "common/config/search/search_values.h"
#include "common/config/training_plan.h"
#include "coordinator/search/rung_study.h"

namespace parallax::client {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// Returns the lines of one field of a message as a file has them, indented.
std::string FieldLines(const Message& message, const FieldDescriptor& field,
                       const std::string& indent) {
  const std::unique_ptr<Message> only(message.New());
  only->CopyFrom(message);
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* const other = message.GetDescriptor()->field(i);
    if (other != &field && other != config_internal::MapsFieldOf(field))
      only->GetReflection()->ClearField(only.get(), other);
  }
  // Lists that are empty are written, too.
  const std::string text = MessageToYaml(*only);
  std::string lines;
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = text.find('\n', begin) + 1;
    const std::string line = text.substr(begin, end - begin);
    if (line.starts_with(field.name() + ":") || (!lines.empty() && line.starts_with(" "))) {
      lines += indent + line;
    } else if (!lines.empty()) {
      break;
    }
    begin = end;
  }
  return lines;
}

// Returns the fields in which `message` differs from `defaults`, as lines.
std::string Changes(const Message& message, const Message& defaults, const std::string& indent) {
  std::string lines;
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor& field = *message.GetDescriptor()->field(i);
    if (config_internal::FindKey(*message.GetDescriptor(), field.name()) == nullptr) continue;
    const FieldDescriptor* const maps = config_internal::MapsFieldOf(field);
    if (!config_internal::Differs(message, defaults, field) &&
        (maps == nullptr || !config_internal::Differs(message, defaults, *maps))) {
      continue;
    }
    // Weights of some lands forbid all others, so they stand together.
    const bool is_whole = field.message_type() == nullptr || field.is_repeated() ||
                          config_internal::IsDistribution(field) ||
                          config_internal::IsQuantity(field) ||
                          field.message_type() == v1::BiomeWeights::descriptor() ||
                          config_internal::HasListForm(*field.message_type());
    if (is_whole) {
      lines += FieldLines(message, field, indent);
      continue;
    }
    lines += indent + field.name() + ":\n" +
             Changes(message.GetReflection()->GetMessage(message, &field),
                     defaults.GetReflection()->GetMessage(defaults, &field), indent + "  ");
  }
  return lines;
}

using Values = std::vector<std::pair<std::string, std::string>>;

// Returns values by paths as nested maps on one line.
std::string Nested(const Values& values) {
  std::string text;
  Values rest = values;
  while (!rest.empty()) {
    const auto head = [](const std::string& path) { return path.substr(0, path.find('.')); };
    const std::string name = head(rest.front().first);
    Values below, others;
    std::string own;
    for (const auto& [path, yaml] : rest) {
      if (path == name) {
        own = yaml;
      } else if (head(path) == name) {
        below.emplace_back(path.substr(name.size() + 1), yaml);
      } else {
        others.emplace_back(path, yaml);
      }
    }
    text += (text.empty() ? "" : ", ") + name + ": " + (below.empty() ? own : Nested(below));
    rest = std::move(others);
  }
  return "{" + text + "}";
}

// Says in a comment which trial it is.
std::string Heading(const v1::SearchStatus& search, const v1::SearchTrial& best) {
  const std::string trial =
      best.number() == 0 ? "the default" : fmt::format("trial {}", best.number());
  std::string text = fmt::format("# The best of the search {}: {}", search.name(), trial);
  if (!best.scores().empty() && best.number() != 0) {
    const v1::SearchFigure& difference = best.scores(best.scores_size() - 1).difference();
    text += fmt::format(", {:+.1f} points of error from the default", difference.value());
  }
  return text + (search.outcome().empty() ? "" : ", " + search.outcome()) + ".\n";
}

std::string Part(const char* name, const std::string& lines) {
  return name + std::string(lines.empty() ? ": {}\n" : ":\n" + lines);
}

}  // namespace

absl::StatusOr<std::string> BestRecipe(const v1::SearchStatus& search) {
  const v1::SearchTrial* best = nullptr;
  for (const v1::SearchTrial& trial : search.trials()) {
    if (search.has_best() && trial.number() == search.best()) best = &trial;
  }
  if (best == nullptr) {
    return FailedPrecondition("search '{}' has no best trial yet{}", search.name(),
                              search.waits_for().empty() ? "" : ": " + search.waits_for());
  }
  v1::StudySpec study = search.study();
  const v1::VariantSpec base = DefaultOf(study);
  study.clear_search();
  study.clear_variants();
  study.set_name(search.name() + "-best");
  if (base.pairs() > 0) study.set_pairs(base.pairs());
  if (base.rigs_per_scene() > 0) study.set_rigs_per_scene(base.rigs_per_scene());
  study.mutable_evaluate()->set_reference("");
  study.mutable_evaluate()->set_heldout_variant("");
  study.add_variants()->set_name("best");
  ASSIGN_OR_RETURN(*study.mutable_variants(0)->mutable_config(),
                   WithSearchValues(base.config(), best->values()));
  ResolveTraining(&study);

  const std::string heading = Heading(search, *best);
  std::string text =
      heading + fmt::format("study: {}\nseed: {}\npairs: {}\nrigs_per_scene: {}\n", study.name(),
                            study.seed(), study.pairs(), study.rigs_per_scene());
  if (study.priority() != 0) text += fmt::format("priority: {}\n", study.priority());
  if (study.memory_mb() != 0) text += fmt::format("memory_mb: {}\n", study.memory_mb());
  if (!study.tags().empty()) text += fmt::format("tags: [{}]\n", fmt::join(study.tags(), ", "));
  v1::TrainSpec train;
  v1::EvaluateSpec evaluate;
  config_internal::ApplyDefaults(&train);
  config_internal::ApplyDefaults(&evaluate);
  text += Part("set", Changes(base.config(), DefaultSceneConfig(), "  ")) +
          Part("train", Changes(study.train(), train, "  ")) +
          Part("evaluate", Changes(study.evaluate(), evaluate, "  ")) +
          "variants:\n  - name: best\n";
  Values values;
  for (const v1::SearchValue& value : best->values()) {
    values.emplace_back(value.path(), value.yaml());
  }
  if (!values.empty()) text += "    set: " + Nested(values) + "\n";
  absl::StatusOr<v1::StudySpec> read = ParseStudy(text, "best.yaml");
  if (read.ok()) read->set_source_yaml(study.source_yaml());
  const bool is_same = read.ok() && read->SerializeAsString() == study.SerializeAsString();
  return is_same ? text : heading + StudyToYaml(study);
}

}  // namespace parallax::client
