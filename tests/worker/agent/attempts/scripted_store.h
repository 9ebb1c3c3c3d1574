// A store that does what a test says, far from this machine.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

class ScriptedStore final : public Store {
 public:
  std::string Uri() const override { return "scripted:"; }
  absl::Status CheckMarker() const override { return marker; }
  absl::Status Put(std::string_view, std::string_view) override { return Answer(); }
  absl::StatusOr<std::string> Get(std::string_view) const override {
    RETURN_IF_ERROR(Answer());
    return std::string("bytes");
  }
  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t, size_t) const override {
    return Get(path);
  }
  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view) const override {
    RETURN_IF_ERROR(Answer());
    return std::vector<StoreEntry>();
  }
  absl::Status RemoveTree(std::string_view) override { return Answer(); }
  absl::StatusOr<std::string> LocalPath(std::string_view) const override {
    return FailedPrecondition("far away");
  }

  absl::Status marker;
  absl::Status error;  // What the next `failures` calls say.
  mutable int failures = 0;
  mutable int calls = 0;

 private:
  absl::Status Answer() const {
    ++calls;
    return failures-- > 0 ? error : absl::OkStatus();
  }
};

}  // namespace parallax
