#include "coordinator/client/search/search_names.h"

#include <fmt/core.h>

#include <algorithm>
#include <tuple>

#include "coordinator/client/views/text.h"
#include "coordinator/view/search_json.h"

namespace parallax::client {

std::string ValueText(const v1::SearchTrial& trial, const v1::SearchField& field) {
  for (const v1::SearchValue& value : trial.values()) {
    if (value.path() != field.path()) continue;
    const bool is_real = field.choices().empty() && !field.integer();
    return is_real ? FormatNumber(std::strtod(value.yaml().c_str(), nullptr)) : value.yaml();
  }
  return "";
}

std::vector<std::string> ShortNames(const v1::SearchSpec& search) {
  std::vector<std::string> names;
  for (const v1::SearchField& field : search.space()) {
    const std::string& path = field.path();
    size_t begin = path.rfind('.');
    const auto is_another = [&](const std::string& suffix) {
      return std::any_of(search.space().begin(), search.space().end(),
                         [&](const v1::SearchField& other) {
                           return other.path() != path && ("." + other.path()).ends_with(suffix);
                         });
    };
    while (begin != std::string::npos && is_another(path.substr(begin))) {
      begin = begin == 0 ? std::string::npos : path.rfind('.', begin - 1);
    }
    names.push_back(begin == std::string::npos ? path : path.substr(begin + 1));
  }
  return names;
}

std::vector<const v1::SearchTrial*> InOrder(const v1::SearchStatus& search) {
  std::vector<const v1::SearchTrial*> order;
  for (const v1::SearchTrial& trial : search.trials()) order.push_back(&trial);
  const auto key = [](const v1::SearchTrial* trial) {
    const v1::SearchScore* const score = LastScore(*trial);
    return std::tuple(trial->number() != 0, -trial->scores_size(),
                      score == nullptr ? 0 : score->objective().value());
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto* a, const auto* b) { return key(a) < key(b); });
  return order;
}

std::string SearchProgress(const v1::SearchStatus& search) {
  int64_t left = 0;
  for (const v1::SearchTrial& trial : search.trials()) {
    left += trial.number() != 0 && trial.ended().empty() ? 1 : 0;
  }
  std::string text = search.state();
  if (search.state() == "running" || search.state() == "failed") {
    text += fmt::format(", rung {} of {}", search.rung() + 1, search.rungs());
    if (left > 0) {
      text += fmt::format(" with {} of {}", left, Plural(search.trials_size() - 1, "trial"));
    }
  }
  return text + ", " + FormatNumber(search.core_hours()) + " core-hours";
}

}  // namespace parallax::client
