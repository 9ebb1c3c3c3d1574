// Lands as files (proto/parallax/v1/biome.proto): the built-in ones of configs/biomes, and the
// user's own. Errors of the loaders are those of config.h. Thread-safe.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/biome.pb.h"

namespace parallax {

// Loads a land. `path` is a file or, if there is no such file, the name of a built-in land.
absl::StatusOr<v1::Biome> LoadBiome(const std::string& path);
// Parses the text of such a file. `file_name` is for messages, and names a land that has no name.
absl::StatusOr<v1::Biome> ParseBiome(std::string_view yaml, const std::string& file_name);

// Returns the built-in lands in order of name. They live as long as the program.
const std::vector<v1::Biome>& BuiltinBiomes();

// Returns the words of one thing that a land chooses from: those of "pines + larches" are two.
std::vector<std::string> WordsOf(const std::string& text);

// The names that formulas know in every land, beside the values of its file.
inline constexpr std::string_view kSiteNames[] = {"low_m",    "middle_m", "high_m",
                                                  "relief_m", "beach_m",  "gorge_m"};

// Returns the value of a formula, sums of products of numbers and names: "tree_line + 0.3 *
// relief_m". `find` gives the value of a name. Errors: kInvalidArgument for a text that is no
// formula; kNotFound with the name that `find` does not know.
absl::StatusOr<double> ValueOfFormula(
    std::string_view formula,
    const std::function<std::optional<double>(std::string_view name)>& find);

}  // namespace parallax
