// Tests that every Store must pass. Instantiate for each implementation:
//   INSTANTIATE_TEST_SUITE_P(Local, StoreConformance, ::testing::Values(&MakeLocalStore));
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/store.h"

namespace parallax {

// A fresh, empty store.
using StoreFactory = std::unique_ptr<Store> (*)();

class StoreConformance : public ::testing::TestWithParam<StoreFactory> {
 protected:
  void SetUp() override { store_ = GetParam()(); }
  std::vector<std::string> Paths(std::string_view prefix) const {
    std::vector<std::string> paths;
    const auto entries = store_->List(prefix);
    EXPECT_TRUE(entries.ok()) << entries.status();
    for (const StoreEntry& entry : *entries) paths.push_back(entry.path);
    return paths;
  }
  std::unique_ptr<Store> store_;
};

TEST_P(StoreConformance, WhatIsPutIsGot) {
  std::string bytes(100000, '\0');
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7 >> 2);
  ASSERT_TRUE(store_->Put("k/.attempt-7/003/left.png", bytes).ok());
  ASSERT_TRUE(store_->Put("empty", "").ok());
  EXPECT_EQ(*store_->Get("k/.attempt-7/003/left.png"), bytes);
  EXPECT_EQ(*store_->Get("empty"), "");
  ASSERT_TRUE(store_->Put("empty", "again").ok());
  EXPECT_EQ(*store_->Get("empty"), "again");
}

TEST_P(StoreConformance, PiecesAreReadFromAnyPlace) {
  ASSERT_TRUE(store_->Put("k/a", "0123456789").ok());
  EXPECT_EQ(*store_->GetPiece("k/a", 0, 4), "0123");
  EXPECT_EQ(*store_->GetPiece("k/a", 8, 100), "89");
  EXPECT_EQ(*store_->GetPiece("k/a", 10, 5), "");
  EXPECT_EQ(store_->GetPiece("no", 0, 5).status().code(), absl::StatusCode::kNotFound);
}

TEST_P(StoreConformance, HasWhatWasPutUntilItIsRemoved) {
  ASSERT_TRUE(store_->Put("k/a", "0123456789").ok());
  ASSERT_TRUE(store_->Put("k/empty", "").ok());
  EXPECT_TRUE(*store_->Has("k/a"));
  EXPECT_TRUE(*store_->Has("k/empty"));
  EXPECT_FALSE(*store_->Has("k/b"));
  EXPECT_FALSE(*store_->Has("no/a"));
  EXPECT_EQ(store_->Has("../a").status().code(), absl::StatusCode::kInvalidArgument);
  ASSERT_TRUE(store_->RemoveTree("k/a").ok());
  EXPECT_FALSE(*store_->Has("k/a"));
}

TEST_P(StoreConformance, LocalFilesArePutAsTheirFactsSayOrNotAtAll) {
  const std::string local = ::testing::TempDir() + "conformance-" + std::to_string(::getpid());
  const std::string bytes(300000, 'x');
  const StoreFile facts{static_cast<int64_t>(bytes.size()), Sha256Hex(bytes)};
  ASSERT_TRUE(WriteFile(local, bytes).ok());
  ASSERT_TRUE(store_->PutFile("k/f", local, facts, /*may_move=*/false).ok());
  EXPECT_EQ(*store_->Get("k/f"), bytes);
  ASSERT_TRUE(store_->PutFile("k/f", local, facts, false).ok());  // Again.
  EXPECT_EQ(store_->PutFile("k/g", local, {facts.size, Sha256Hex("y")}, false).code(),
            absl::StatusCode::kDataLoss);
  EXPECT_EQ(store_->Get("k/g").status().code(), absl::StatusCode::kNotFound);
  ASSERT_TRUE(store_->PutFile("k/h", local, facts, /*may_move=*/true).ok());
  EXPECT_EQ(*store_->Get("k/h"), bytes);
  ::unlink(local.c_str());
}

TEST_P(StoreConformance, AbsentThingsAreNotFoundOrEmpty) {
  EXPECT_EQ(store_->Get("no").status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(store_->Get("no/such").status().code(), absl::StatusCode::kNotFound);
  EXPECT_TRUE(Paths("no/such").empty());
  EXPECT_TRUE(Paths("").empty());
  EXPECT_TRUE(store_->RemoveTree("no/such").ok());
}

TEST_P(StoreConformance, ListsFilesBelowAFolderInOrderWithTheirSizes) {
  for (const char* path : {"b/2", "b/10", "a", "b/c/d", "bb/1"}) {
    ASSERT_TRUE(store_->Put(path, path).ok());
  }
  EXPECT_EQ(Paths(""), (std::vector<std::string>{"a", "b/10", "b/2", "b/c/d", "bb/1"}));
  EXPECT_EQ(Paths("b"), (std::vector<std::string>{"b/10", "b/2", "b/c/d"}));
  EXPECT_EQ((*store_->List("b"))[0].size, 4);
}

TEST_P(StoreConformance, RemoveTreeTakesTheFolderAndNothingElse) {
  for (const char* path : {"k/.attempt-1/a", "k/.attempt-1/b/c", "k/.attempt-2/a"}) {
    ASSERT_TRUE(store_->Put(path, "x").ok());
  }
  ASSERT_TRUE(store_->RemoveTree("k/.attempt-1").ok());
  EXPECT_EQ(Paths(""), (std::vector<std::string>{"k/.attempt-2/a"}));
  ASSERT_TRUE(store_->RemoveTree("k/.attempt-2/a").ok());
  EXPECT_TRUE(Paths("").empty());
}

TEST_P(StoreConformance, PathsThatLeaveTheStoreAreRefused) {
  for (const std::string path : {"", "/etc/passwd", "..", "../x", "a/../../x", "a//b", "a/", "./a",
                                 "a/.", "a\\b", "a/.tmp-1", ".parallax-store"}) {
    EXPECT_EQ(store_->Put(path, "x").code(), absl::StatusCode::kInvalidArgument) << path;
    EXPECT_EQ(store_->Get(path).status().code(), absl::StatusCode::kInvalidArgument) << path;
    EXPECT_EQ(store_->RemoveTree(path).code(), absl::StatusCode::kInvalidArgument) << path;
    EXPECT_FALSE(store_->LocalPath(path).ok()) << path;
    if (!path.empty()) {
      EXPECT_FALSE(store_->List(path).ok()) << path;
    }
  }
  const std::string with_nul("a\0b", 3);
  EXPECT_EQ(store_->Put(with_nul, "x").code(), absl::StatusCode::kInvalidArgument);
}

TEST_P(StoreConformance, WritersAtTheSameTimeLeaveWholeFiles) {
  std::vector<std::thread> threads;
  for (char c = 'a'; c < 'e'; ++c) {
    threads.emplace_back([this, c] {
      for (int i = 0; i < 10; ++i) {
        EXPECT_TRUE(store_->Put("shared/file", std::string(10000, c)).ok());
        EXPECT_TRUE(store_->Put("own/" + std::string(1, c) + std::to_string(i), "x").ok());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::string bytes = *store_->Get("shared/file");
  EXPECT_EQ(bytes, std::string(10000, bytes[0]));
  EXPECT_EQ(Paths("own").size(), 40u);
  EXPECT_EQ(Paths("").size(), 41u);
}

}  // namespace parallax
