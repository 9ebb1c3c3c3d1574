// Replies that always fit into a message. What workers and clients send is bounded by
// validation.h, but a database may hold longer texts of an earlier version, and lists grow.
//
// Pure and thread-safe.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <cstddef>
#include <vector>

#include "parallax/v1/service.pb.h"

namespace parallax {

// A quarter of what gRPC carries here (kMaxRpcMessageBytes).
inline constexpr size_t kMaxReplyBytes = 16 << 20;

// Workers that a coordinator takes: a list of all, each with the longest texts that CheckHello lets
// pass, is one reply.
inline constexpr size_t kMostWorkers = 20'000;

// Cuts every text of `message`, nested ones included, to `most` bytes; a cut one ends with "...".
void CutTexts(google::protobuf::Message* message, size_t most);

// Makes a status fit: cuts texts, then drops problems but the newest three of each variant, then
// the study file in `spec`, then `spec` itself, each only as long as it is needed.
void FitStudy(v1::StudyStatus* study);

// Moves items with their texts cut into a reply, at least one and as long as the reply keeps below
// kMaxReplyBytes. False if some are left: the caller asks again from the last one on.
template <typename Item>
bool AddItems(std::vector<Item>& items, google::protobuf::RepeatedPtrField<Item>* reply,
              size_t most_text) {
  size_t bytes = 0;
  for (Item& item : items) {
    CutTexts(&item, most_text);
    bytes += item.ByteSizeLong() + 8;  // And its tag and length.
    if (bytes > kMaxReplyBytes && !reply->empty()) return false;
    *reply->Add() = std::move(item);
  }
  return true;
}

}  // namespace parallax
