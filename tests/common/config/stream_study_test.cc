// Endless studies: how a file says that a study is one, and what it may say of its stream.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using testing::HasSubstr;

const char kEndless[] =
    "study: drive\n"
    "pairs: endless\n"
    "rigs_per_scene: 20\n"
    "variants:\n"
    "  - name: rooms\n"
    "  - name: land\n";

std::string StreamError(const std::string& more) {
  const auto study = ParseStudy(kEndless + more, "drive.yaml");
  return study.ok() ? "" : std::string(study.status().message());
}

TEST(StreamStudyTest, EndlessPairsHaveTheDefaultsOfAStream) {
  const auto study = ParseStudy(kEndless, "drive.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  ASSERT_TRUE(study->has_stream());
  EXPECT_EQ(study->stream().chunk_pairs(), 200);
  EXPECT_EQ(study->stream().chunks_ahead(), 3);
  EXPECT_EQ(study->stream().uses(), 1);
  EXPECT_EQ(study->stream().silent_s(), 600);
  EXPECT_EQ(study->pairs(), 200);
}

TEST(StreamStudyTest, TheLockFileReadsBackToTheSameStudy) {
  const std::string stream =
      "stream:\n  chunk_pairs: 60\n  uses: 4\n  keep_s: 90\n"
      "  mix: [{variant: rooms, weight: 3, until_pair: 600}, {variant: land}]\n";
  const auto study = ParseStudy(kEndless + stream, "drive.yaml");
  ASSERT_TRUE(study.ok()) << study.status();
  auto again = ParseStudy(StudyToYaml(*study), "study.lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  again->set_source_yaml(study->source_yaml());
  EXPECT_EQ(again->SerializeAsString(), study->SerializeAsString());
}

TEST(StreamStudyTest, AStudyWithANumberOfPairsHasNoStream) {
  const auto study =
      ParseStudy("study: s\npairs: 4\nstream: {uses: 2}\nvariants: [{name: a}]\n", "s.yaml");
  EXPECT_THAT(std::string(study.status().message()),
              HasSubstr("s.yaml:3: stream: beside a number of pairs, allowed only with `pairs: "
                        "endless`"));
}

TEST(StreamStudyTest, WhatIsWrongInAStreamIsNamed) {
  EXPECT_THAT(
      StreamError("stream: {chunk_pairs: 0}\n"),
      HasSubstr("drive.yaml:7: stream.chunk_pairs: 0 is out of range, allowed 1 to 100000"));
  EXPECT_THAT(StreamError("stream:\n  mix: [{variant: room}]\n"),
              HasSubstr("drive.yaml:8: stream.mix[0].variant: \"room\" is not known, did you mean "
                        "rooms"));
  EXPECT_THAT(StreamError("stream:\n  mix: [{variant: land, from_pair: 9, until_pair: 9}]\n"),
              HasSubstr("stream.mix[0].until_pair: 9 is not after from_pair"));
  EXPECT_THAT(StreamError("stream:\n  mix: [{variant: land, from_pair: 100}]\n"),
              HasSubstr("stream.mix: no variant has a share from pair 0 on"));
  EXPECT_THAT(StreamError("stream:\n  mix: [{variant: land, until_pair: 100}]\n"),
              HasSubstr("stream.mix: no variant has a share from pair 100 on"));
  EXPECT_THAT(StreamError("train: {trainer: builtin}\n"),
              HasSubstr("train: beside `pairs: endless`"));
  EXPECT_THAT(StreamError("stream: {use: 2}\n"), HasSubstr("did you mean uses"));
  const auto pairs =
      ParseStudy("study: s\npairs: endless\nvariants: [{name: a, pairs: 4}]\n", "s.yaml");
  EXPECT_THAT(std::string(pairs.status().message()),
              HasSubstr("s.yaml:3: variants[0].pairs: 4, allowed in an endless study is none"));
  const auto word = ParseStudy("study: s\npairs: endles\nvariants: [{name: a}]\n", "s.yaml");
  EXPECT_THAT(std::string(word.status().message()), HasSubstr("s.yaml:2: pairs: "));
}

class ExtendedStreamTest : public FolderTest {};

TEST_F(ExtendedStreamTest, AFiniteStudyMayExtendAnEndlessOneAndTheReverse) {
  ASSERT_TRUE(
      WriteFile(dir_ + "/endless.yaml", kEndless + std::string("stream: {uses: 2}\n")).ok());
  const auto finite = ParseStudy("extends: endless.yaml\npairs: 4\n", dir_ + "/finite.yaml");
  ASSERT_TRUE(finite.ok()) << finite.status();
  EXPECT_FALSE(finite->has_stream());
  EXPECT_EQ(finite->pairs(), 4);
  const auto other =
      ParseStudy("extends: endless.yaml\nstream: {chunk_pairs: 40}\n", dir_ + "/other.yaml");
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_EQ(other->stream().uses(), 2);
  EXPECT_EQ(other->stream().chunk_pairs(), 40);
}

}  // namespace
}  // namespace parallax
