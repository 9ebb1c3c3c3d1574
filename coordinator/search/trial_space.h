// The space of a search: from points of the unit cube to values of fields, and to trials. Pure and
// thread-safe.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/search.pb.h"

namespace parallax {

using SearchSpace = google::protobuf::RepeatedPtrField<v1::SearchField>;
using SearchValues = google::protobuf::RepeatedPtrField<v1::SearchValue>;

// Returns the values at a point of the unit cube that has a coordinate for each field of the space.
// A field whose conditions fail has no value; its coordinate is used up all the same, so that
// fields after it keep theirs.
SearchValues ValuesAt(const SearchSpace& space, std::span<const double> point);

// Returns whether the conditions of the field hold, by values of the fields before it.
bool IsVaried(const v1::SearchField& field, const SearchValues& values);

// Returns the text of the value that the field has among these; null where its conditions fail.
const std::string* ValueOf(const SearchValues& values, const std::string& path);

// Returns where a value of a field with a range lies in it: in [0, 1], in the logarithm where the
// field is varied in it.
double PlaceInRange(const v1::SearchField& field, const std::string& yaml);

// Checks that a trial's study may be submitted, by the rules of configs and studies. Errors:
// kInvalidArgument.
absl::Status CheckTrial(const v1::StudySpec& search, const v1::SearchTrial& trial);

// Returns the trials of a search, the default first, numbered from 0, and `wanted` others at
// Sobol's points. Points whose config the rules of configs forbid, or an earlier trial or the
// default has, are left out; a small space may so have fewer trials than asked for. More trials
// begin with the same ones. Errors: kInvalidArgument if no point of the space is a valid trial,
// with the reason of the first.
absl::StatusOr<std::vector<v1::SearchTrial>> ProposeTrials(const v1::StudySpec& search, int wanted);

}  // namespace parallax
