// Applies the values that a search proposes to a scene config. Pure and thread-safe.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/search.pb.h"

namespace parallax {

// Returns `base` with the values, merged as a variant's `set` that has them: a path with dots names
// nested fields. The result is checked as a variant's config is. A path that stands twice has its
// last value. Errors: kInvalidArgument with up to 20 lines "field.path: what was seen, what is
// allowed".
absl::StatusOr<v1::SceneConfig> WithSearchValues(
    const v1::SceneConfig& base, const google::protobuf::RepeatedPtrField<v1::SearchValue>& values);

// Returns how many points the space of a checked search has: the product of choices and of whole
// numbers, whatever their conditions, and at most `most`, which a range of other numbers has.
int64_t PointsOfSpace(const v1::SearchSpec& search, int64_t most);

// Returns the YAML text of a number that the field has in a trial: the shortest that reads back to
// the same number; rounded to a whole one for a field of whole numbers.
std::string SearchNumberText(const v1::SearchField& field, double value);

}  // namespace parallax
