// Lists of JSON values. Pure.
#pragma once

#include <nlohmann/json.hpp>

namespace parallax {

// Returns an array of `json_of(item)` for each of `items`.
inline nlohmann::ordered_json JsonList(const auto& items, const auto& json_of) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& item : items) list.push_back(json_of(item));
  return list;
}

}  // namespace parallax
