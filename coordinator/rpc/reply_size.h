// Makes replies fit into a message. validation.h bounds the texts that workers and clients send,
// but a database may hold longer texts of an earlier version, and lists grow.
//
// Pure functions; thread-safe.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <cstddef>
#include <vector>

#include "parallax/v1/service.pb.h"

namespace parallax {

// Largest list in a reply, in bytes: a quarter of kMaxRpcMessageBytes.
inline constexpr size_t kMaxReplyBytes = 16 << 20;

// Largest number of workers of a coordinator: a list of all of them, each with the longest texts
// that CheckHello accepts, is one reply.
inline constexpr size_t kMostWorkers = 20'000;

// Cuts every text of `message` and of its nested messages to `most` bytes; a cut text ends with
// "...".
void CutTexts(google::protobuf::Message* message, size_t most);

// Makes a status fit. As far as necessary, it cuts texts, then drops all problems but the newest
// three of each variant, then the study file in `spec`, then `spec` itself.
void FitStudy(v1::StudyStatus* study);

// Moves items into a reply, with their texts cut to `most_text` bytes: at least one item, and more
// while the reply stays below kMaxReplyBytes. Returns false if items are left over; the client then
// asks for the next page.
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
