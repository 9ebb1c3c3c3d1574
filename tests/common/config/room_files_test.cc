// Kinds of rooms as files: what is refused and how, and how a config takes those of the user.
#include "common/config/files/room_files.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/config/catalogue_names.h"
#include "common/config/config.h"
#include "tests/folder_test.h"

namespace parallax {
namespace {

using google::protobuf::util::MessageDifferencer;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kWorkshop[] =
    "like: office\n"
    "furniture:\n"
    "  - {group: bench, classes: [SimpleDesk], count: [2, 4], stand: on_floor, rows_m: 2.2}\n"
    "  - {group: stool, classes: [BarChair], stand: in_front_of, anchor: bench, gap_m: [-0.2, 0],\n"
    "     faces_anchor: true}\n"
    "  - {group: shelf, classes: [LargeShelf, CellShelf], count: [3, 5], weight: 3}\n"
    "things:\n"
    "  - {bearer: bench, classes: [Hardware, Can], count: [2, 6]}\n"
    "wishes:\n"
    "  - {wish: distance, group: stool, target: bench, range: [0.2, 0.9], weight: 2}\n";

// Replaces a part of kWorkshop.
std::string Workshop(const std::string& part, const std::string& by) {
  std::string text = kWorkshop;
  const size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return text.replace(at, part.size(), by);
}

TEST(RoomKinds, BuiltInOnesAreReadAndCoverTheKindsOfRooms) {
  EXPECT_EQ(BuiltinRoomKinds().size(), 13u) << "nine kinds, and halls of four";
  for (const std::string& kind : RoomKindNames()) {
    EXPECT_EQ(LoadRoomKind(kind)->name(), kind);
  }
  const auto workshop = ParseRoomKind(kWorkshop, "dir/workshop.yaml");
  ASSERT_TRUE(workshop.ok()) << workshop.status();
  EXPECT_EQ(workshop->name(), "workshop");
  EXPECT_EQ(workshop->furniture(1).gap_m().near(), -0.2);
}

TEST(RoomKinds, EachWrongFileNamesLineFieldAndWhatIsAllowed) {
  const struct {
    const char* part;
    const char* by;
    const char* want;  // The beginning of the message.
  } rows[] = {
      {"like: office", "like: offices",
       "workshop.yaml:1: like: \"offices\" is not known, did you mean office?"},
      {"[SimpleDesk]", "[SimpleDesc]",
       "workshop.yaml:3: furniture[0].classes[0]: \"SimpleDesc\" is not known, did you mean "
       "SimpleDesk?"},
      {"[SimpleDesk]", "[]",
       "workshop.yaml:3: furniture[0].classes: an empty list, allowed is at least 1"},
      {"[2, 4]", "[4, 2]",
       "workshop.yaml:3: furniture[0].count: low 4 is above high 2, allowed is the lower one "
       "first"},
      {"[2, 4]", "[2, 4, 6]",
       "workshop.yaml:3: furniture[0].count: a list of 3, allowed is [low, "},
      {"stand: on_floor", "stand: on_flor",
       "workshop.yaml:3: furniture[0].stand: \"on_flor\" is not known, did you mean on_floor?"},
      {"stand: on_floor, ", "",
       "workshop.yaml:3: furniture[0].rows_m: given, but against_wall has none"},
      {"anchor: bench, ", "", "workshop.yaml:4: furniture[1]: no anchor, which in_front_of needs"},
      {"anchor: bench, ", "anchor: shelf, ",
       "workshop.yaml:4: furniture[1].anchor: \"shelf\" is not known (allowed: bench)"},
      {"group: shelf", "group: bench",
       "workshop.yaml:6: furniture[2].group: \"bench\" is there already"},
      {"bearer: bench", "bearer: bank", "workshop.yaml:8: things[0].bearer: \"bank\" is not known"},
      {"target: bench, ", "", "workshop.yaml:10: wishes[0]: no target, which distance needs"},
      {"wish: distance", "wish: facing",
       "workshop.yaml:10: wishes[0].range: given, but facing has none"},
      {"wish: distance", "wish: distant",
       "workshop.yaml:10: wishes[0].wish: \"distant\" is not known, did you mean distance?"},
  };
  for (const auto& row : rows) {
    const auto kind = ParseRoomKind(Workshop(row.part, row.by), "workshop.yaml");
    EXPECT_THAT(std::string(ToStd(kind.status().message())), StartsWith(row.want));
  }
  EXPECT_THAT(std::string(ToStd(ParseRoomKind("like: office\n", "a.yaml").status().message())),
              StartsWith("a.yaml: no furniture, allowed is one group at least"));
}

class OwnRooms : public FolderTest {
 protected:
  void Write(const std::string& name, const std::string& text) {
    std::ofstream(dir_ + "/" + name) << text;
  }
  absl::StatusOr<v1::StudySpec> Study(const std::string& room) {
    return ParseStudy(
        "study: s\npairs: 4\nvariants: [{name: a, base: indoor, set: {room: " + room + "}}]",
        dir_ + "/s.yaml");
  }
};

TEST_F(OwnRooms, AreInTheConfigAndReadBackWithoutTheirFile) {
  Write("workshop.yaml", kWorkshop);
  const auto study = Study("{room_files: [workshop.yaml], kinds: [workshop, office]}");
  ASSERT_TRUE(study.ok()) << study.status();
  const v1::RoomConfig& room = study->variants(0).config().room();
  ASSERT_EQ(room.own_kinds_size(), 1);
  EXPECT_EQ(room.own_kinds(0).name(), "workshop");
  EXPECT_EQ(room.room_files_size(), 0);

  std::filesystem::remove(dir_ + "/workshop.yaml");
  auto again = ParseStudy(StudyToYaml(*study), dir_ + "/lock.yaml");
  ASSERT_TRUE(again.ok()) << again.status();
  again->set_source_yaml(study->source_yaml());
  EXPECT_TRUE(MessageDifferencer::Equals(*study, *again)) << StudyToYaml(*study);
  EXPECT_TRUE(ValidateStudy(*study).ok()) << ValidateStudy(*study);
}

TEST_F(OwnRooms, AreRefusedWithFileAndLineAndAsMessagesWithTheirPath) {
  const auto message = [&](const std::string& room) {
    return std::string(ToStd(Study(room).status().message()));
  };
  Write("workshop.yaml", Workshop("[SimpleDesk]", "[SimpleDesc]"));
  EXPECT_THAT(message("{room_files: [workshop.yaml], kinds: [workshop]}"),
              StartsWith(dir_ + "/workshop.yaml:3: furniture[0].classes[0]: \"SimpleDesc\""));
  Write("workshop.yaml", kWorkshop);
  EXPECT_THAT(message("{room_files: [workshop.yaml], kinds: [workshp]}"),
              HasSubstr("room.kinds[0]: \"workshp\" is not known, did you mean workshop?"));
  EXPECT_THAT(message("{kinds: [workshop]}"), HasSubstr("\"workshop\" is not known"));
  EXPECT_THAT(message("{kinds: [stairs]}"), HasSubstr("\"stairs\" is not known"));
  Write("office.yaml", kWorkshop);
  EXPECT_THAT(message("{room_files: [office.yaml], kinds: [office]}"),
              HasSubstr("\"office\" is the name of another kind"));

  auto study = Study("{room_files: [workshop.yaml], kinds: [workshop]}").value();
  v1::RoomConfig& room = *study.mutable_variants(0)->mutable_config()->mutable_room();
  room.mutable_own_kinds(0)->mutable_furniture(0)->set_rows_m(99);
  EXPECT_THAT(std::string(ToStd(ValidateStudy(study).message())),
              StartsWith("variants[0].config.room.own_kinds[0].furniture[0].rows_m: 99 is out of"));
}

}  // namespace
}  // namespace parallax
