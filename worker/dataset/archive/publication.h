// The parts of a dataset for hosts and search engines: the YAML head of README.md, the licence, the
// citation, and croissant.json (https://docs.mlcommons.org/croissant, version 1.0). Archives and
// exports share them. All functions are pure; none touches a disk.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace parallax {

// A column of croissant.json's table of pairs.
struct CroissantField {
  std::string name;         // Letters, digits and "_".
  std::string description;  // One sentence.
  std::string type;         // A schema.org type without its prefix: "Text", "Integer", "Boolean".
};

// A dataset as its croissant.json describes it: one file whose rows are the pairs.
struct Publication {
  std::string name;            // Letters, digits, "_", "-", "." and "/"; "/" becomes "-".
  std::string description;     // Plain text.
  std::string version;         // Semantic version: "0.2.0".
  bool other_licence = false;  // LICENSE is not DataLicence(false).
  std::string table_file;      // File of the rows, relative to croissant.json: "index.jsonl".
  std::string table_bytes;     // Its content, which is hashed.
  // Path of a row's list in a JSON file ("$.frames[*]"), or empty: a row is a line of JSON.
  std::string json_path;
  std::vector<CroissantField> fields;
};

// Returns the YAML head of a dataset card as Hugging Face reads it, with both "---" lines.
// `configs` says in YAML, lines with their ends, which files are the data; empty: nothing that
// Hugging Face reads as it is, so that its viewer stays off instead of showing a folder of
// pictures.
std::string CardHead(int64_t pairs, bool other_licence, const std::string& configs);

// Returns a Markdown section on how to cite, with BibTeX, and on the licence of the data.
std::string CitationSection(bool other_licence);

// Returns the text of a dataset's LICENSE: CC BY 4.0; with `own_content`, what the maker brought
// along (pictures, texture sets, surroundings, meshes) keeps its own licence.
std::string DataLicence(bool own_content);

// Returns the Croissant description as JSON-LD, with one table, "pairs".
std::string CroissantJson(const Publication& publication);

}  // namespace parallax
