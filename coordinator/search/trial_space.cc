#include "coordinator/search/trial_space.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>

#include "common/config/config.h"
#include "common/config/search/search_values.h"
#include "coordinator/search/rung_study.h"
#include "coordinator/search/sobol.h"
#include "coordinator/study/keys.h"

namespace parallax {
namespace {

// So many points are tried for each trial that is asked for.
constexpr int kPointsPerTrial = 16;
constexpr int kFewestPoints = 256;

// Six digits: nobody reads more, and a file of the best recipe shows them.
double Rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return std::atof(text);
}

double At(const v1::SearchField& field, double coordinate) {
  // Whole numbers have equal shares: that of `high` ends one beyond it.
  const double low = field.low(), high = field.high() + (field.integer() ? 1 : 0);
  const double value =
      field.log() ? low * std::pow(high / low, coordinate) : low + coordinate * (high - low);
  return std::clamp(field.integer() ? std::floor(value) : Rounded(value), field.low(),
                    field.high());
}

}  // namespace

bool IsVaried(const v1::SearchField& field, const SearchValues& values) {
  return std::all_of(field.when().begin(), field.when().end(), [&](const auto& condition) {
    const std::string* value = ValueOf(values, condition.path());
    return value != nullptr &&
           std::count(condition.values().begin(), condition.values().end(), *value) > 0;
  });
}

const std::string* ValueOf(const SearchValues& values, const std::string& path) {
  for (const v1::SearchValue& value : values) {
    if (value.path() == path) return &value.yaml();
  }
  return nullptr;
}

SearchValues ValuesAt(const SearchSpace& space, std::span<const double> point) {
  SearchValues values;
  for (int i = 0; i < space.size(); ++i) {
    const v1::SearchField& field = space[i];
    if (!IsVaried(field, values)) continue;
    const double coordinate = point[static_cast<size_t>(i)];
    v1::SearchValue& value = *values.Add();
    value.set_path(field.path());
    if (field.choices().empty()) {
      value.set_yaml(SearchNumberText(field, At(field, coordinate)));
    } else {
      const int choice = static_cast<int>(coordinate * field.choices_size());
      value.set_yaml(field.choices(std::min(choice, field.choices_size() - 1)));
    }
  }
  return values;
}

double PlaceInRange(const v1::SearchField& field, const std::string& yaml) {
  const double value = std::atof(yaml.c_str());
  const double place = field.log()
                           ? std::log(value / field.low()) / std::log(field.high() / field.low())
                           : (value - field.low()) / (field.high() - field.low());
  return std::isfinite(place) ? std::clamp(place, 0.0, 1.0) : 0;
}

absl::Status CheckTrial(const v1::StudySpec& search, const v1::SearchTrial& trial) {
  ASSIGN_OR_RETURN(const v1::StudySpec alone, RungStudy(search, 0, {v1::SearchTrial(), trial}));
  return ValidateStudy(alone);
}

absl::StatusOr<std::vector<v1::SearchTrial>> ProposeTrials(const v1::StudySpec& search,
                                                           int wanted) {
  const SearchSpace& space = search.search().space();
  std::vector<v1::SearchTrial> trials(1);
  std::set<std::string> configs = {DeterministicBytes(DefaultOf(search).config())};
  const auto points = SobolPoints(
      search.seed(), static_cast<size_t>(std::max(kFewestPoints, kPointsPerTrial * wanted)),
      static_cast<size_t>(space.size()));
  absl::Status first_refusal;
  for (const std::vector<double>& point : points) {
    if (static_cast<int>(trials.size()) > wanted) break;
    v1::SearchTrial trial;
    trial.set_number(static_cast<int>(trials.size()));
    *trial.mutable_values() = ValuesAt(space, point);
    const absl::StatusOr<v1::SceneConfig> config =
        WithSearchValues(DefaultOf(search).config(), trial.values());
    absl::Status refusal = config.status();
    if (refusal.ok()) {
      if (!configs.insert(DeterministicBytes(*config)).second) continue;
      refusal = CheckTrial(search, trial);
    }
    if (refusal.ok()) {
      trials.push_back(std::move(trial));
    } else if (first_refusal.ok()) {
      first_refusal = refusal;
    }
  }
  if (trials.size() > 1) return trials;
  return InvalidArgument(
      "search.space of study '{}': no point of it is a valid trial{}", search.name(),
      first_refusal.ok() ? ": all are the default's config"
                         : "; the first: " + std::string(first_refusal.message()));
}

}  // namespace parallax
