#include "worker/dataset/archive/publication.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/hash.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kLicenceUrl[] = "https://creativecommons.org/licenses/by/4.0/";

constexpr char kCitation[] =
    "@inproceedings{yan2026stereo,\n"
    "  title     = {What Makes Good Synthetic Training Data for Zero-Shot Stereo Matching?},\n"
    "  author    = {Yan, David and Raistrick, Alexander and Deng, Jia},\n"
    "  booktitle = {CVPR},\n"
    "  year      = {2026}\n"
    "}\n";

// Hugging Face's classes of size: n<1K, 1K<n<10K, ...
std::string SizeCategory(int64_t pairs) {
  const std::pair<int64_t, const char*> classes[] = {{1'000, "n<1K"},
                                                     {10'000, "1K<n<10K"},
                                                     {100'000, "10K<n<100K"},
                                                     {1'000'000, "100K<n<1M"},
                                                     {10'000'000, "1M<n<10M"}};
  for (const auto& [below, name] : classes) {
    if (pairs < below) return name;
  }
  return "10M<n<100M";
}

// The context that Croissant 1.0 prescribes, without keys that are not used here.
Json Context() {
  return {{"@language", "en"},
          {"@vocab", "https://schema.org/"},
          {"sc", "https://schema.org/"},
          {"cr", "http://mlcommons.org/croissant/"},
          {"dct", "http://purl.org/dc/terms/"},
          {"citeAs", "cr:citeAs"},
          {"column", "cr:column"},
          {"conformsTo", "dct:conformsTo"},
          {"dataType", {{"@id", "cr:dataType"}, {"@type", "@vocab"}}},
          {"extract", "cr:extract"},
          {"field", "cr:field"},
          {"fileObject", "cr:fileObject"},
          {"jsonPath", "cr:jsonPath"},
          {"recordSet", "cr:recordSet"},
          {"source", "cr:source"}};
}

Json Field(const CroissantField& field, const Publication& publication) {
  Json extract;
  if (publication.json_path.empty()) {
    extract["column"] = field.name;
  } else {
    extract["jsonPath"] = publication.json_path + "." + field.name;
  }
  return {{"@type", "cr:Field"},
          {"@id", "pairs/" + field.name},
          {"name", field.name},
          {"description", field.description},
          {"dataType", "sc:" + field.type},
          {"source", {{"fileObject", {{"@id", publication.table_file}}}, {"extract", extract}}}};
}

}  // namespace

std::string CardHead(int64_t pairs, bool other_licence, const std::string& configs) {
  return std::string("---\nlicense: ") + (other_licence ? "other" : "cc-by-4.0") +
         "\ntask_categories:\n- depth-estimation\n"
         "tags:\n- stereo-matching\n- disparity\n- synthetic\n- parallax\n"
         "size_categories:\n- " +
         SizeCategory(pairs) + "\n" + (configs.empty() ? "viewer: false\n" : configs) + "---\n";
}

std::string CitationSection(bool other_licence) {
  return std::string("## Licence and citation\n\n") +
         (other_licence ? "The file `LICENSE` states the licence." : "CC BY 4.0, see `LICENSE`.") +
         " The generator follows:\n\n```bibtex\n" + kCitation + "```\n";
}

std::string DataLicence(bool own_content) {
  std::string text =
      "The authors of Parallax claim no rights in images and ground truth that it makes: they\n"
      "belong to whoever made them with it. Unless that person replaces this file, they are under\n"
      "the Creative Commons Attribution 4.0 International licence (CC BY 4.0):\n" +
      std::string(kLicenceUrl) + "\n";
  if (own_content) {
    text +=
        "\nThe maker brought along some of what images show: pictures (materials.picture_dir),\n"
        "texture sets (materials.texture_dir), surroundings (lighting.hdri_dir) or meshes\n"
        "(assets.include). "
        "These keep their own licence, which this program does not know.\n";
  }
  return text;
}

std::string CroissantJson(const Publication& publication) {
  std::string name = publication.name;
  std::replace(name.begin(), name.end(), '/', '-');
  const bool lines = publication.json_path.empty();
  Json json;
  json["@context"] = Context();
  json["@type"] = "sc:Dataset";
  json["conformsTo"] = "http://mlcommons.org/croissant/1.0";
  json["name"] = name;
  json["description"] = publication.description;
  json["version"] = publication.version;
  json["license"] = publication.other_licence ? "LICENSE" : kLicenceUrl;
  json["citeAs"] = kCitation;
  json["keywords"] = {"stereo matching", "disparity", "depth", "synthetic"};
  json["distribution"] =
      Json::array({{{"@type", "cr:FileObject"},
                    {"@id", publication.table_file},
                    {"name", publication.table_file},
                    {"contentUrl", publication.table_file},
                    {"contentSize", fmt::format("{} B", publication.table_bytes.size())},
                    {"encodingFormat", lines ? "application/jsonlines" : "application/json"},
                    {"sha256", Sha256Hex(publication.table_bytes)}}});
  Json fields = Json::array();
  for (const CroissantField& field : publication.fields)
    fields.push_back(Field(field, publication));
  json["recordSet"] = Json::array({{{"@type", "cr:RecordSet"},
                                    {"@id", "pairs"},
                                    {"name", "pairs"},
                                    {"description", "A row for each stereo pair."},
                                    {"field", fields}}});
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace parallax
