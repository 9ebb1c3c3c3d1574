#include "common/config/files/land_files.h"

#include <cctype>
#include <charconv>
#include <system_error>

#include "common/config/check/biome_check.h"
#include "common/config/config_text.h"
#include "common/config/yaml/named_files.h"

namespace parallax {

using config_internal::ConfigText;

namespace {

// Reads a formula from left to right.
class Formula {
 public:
  using Find = std::function<std::optional<double>(std::string_view)>;
  Formula(std::string_view text, const Find& find) : text_(text), find_(find) {}

  absl::StatusOr<double> Value() {
    ASSIGN_OR_RETURN(double sum, Product());
    while (true) {
      const char sign = Next("+-");
      if (sign == 0) break;
      ASSIGN_OR_RETURN(const double term, Product());
      sum = sign == '+' ? sum + term : sum - term;
    }
    if (at_ < text_.size()) return NoFormula();
    return sum;
  }

 private:
  absl::StatusOr<double> Product() {
    ASSIGN_OR_RETURN(double product, Factor());
    while (Next("*") != 0) {
      ASSIGN_OR_RETURN(const double factor, Factor());
      product *= factor;
    }
    return product;
  }

  absl::StatusOr<double> Factor() {
    SkipSpaces();
    size_t end = at_;
    const auto is_word = [&](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
    };
    while (end < text_.size() && is_word(text_[end])) ++end;
    const std::string word(text_.substr(at_, end - at_));
    if (word.empty()) return NoFormula();
    at_ = end;
    if (std::isdigit(static_cast<unsigned char>(word[0]))) {
      double number = 0;
      const auto read = std::from_chars(word.data(), word.data() + word.size(), number);
      if (read.ec != std::errc() || read.ptr != word.data() + word.size()) return NoFormula();
      return number;
    }
    const std::optional<double> value = find_(word);
    if (!value) return NotFound("{}", word);
    return *value;
  }

  // Takes the next character if it is one of `wanted`; else returns 0.
  char Next(std::string_view wanted) {
    SkipSpaces();
    if (at_ == text_.size() || wanted.find(text_[at_]) == std::string_view::npos) return 0;
    return text_[at_++];
  }

  void SkipSpaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  absl::Status NoFormula() const {
    return InvalidArgument("\"{}\" is no formula, allowed are numbers and names with +, - and *",
                           text_);
  }

  const std::string_view text_;
  const Find& find_;
  size_t at_ = 0;
};

}  // namespace

std::vector<std::string> WordsOf(const std::string& text) {
  constexpr std::string_view kBetween = " + ";
  std::vector<std::string> words;
  size_t begin = 0;
  for (size_t end; (end = text.find(kBetween, begin)) != std::string::npos;) {
    words.push_back(text.substr(begin, end - begin));
    begin = end + kBetween.size();
  }
  words.push_back(text.substr(begin));
  return words;
}

absl::StatusOr<double> ValueOfFormula(
    std::string_view formula, const std::function<std::optional<double>(std::string_view)>& find) {
  return Formula(formula, find).Value();
}

absl::StatusOr<v1::Biome> ParseBiome(std::string_view yaml, const std::string& file_name) {
  return config_internal::ParseNamed<v1::Biome>(yaml, file_name, &config_internal::CheckBiome);
}

absl::StatusOr<v1::Biome> LoadBiome(const std::string& path) {
  ASSIGN_OR_RETURN(const ConfigText text, config_internal::ReadConfigText(path, "biomes"));
  return ParseBiome(text.text, text.file);
}

const std::vector<v1::Biome>& BuiltinBiomes() {
  static const auto& biomes = *new std::vector<v1::Biome>(
      config_internal::ParseBuiltins<v1::Biome>("biomes/", &ParseBiome));
  return biomes;
}

}  // namespace parallax
