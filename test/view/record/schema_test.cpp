// A recording has the definitions of its types, in the form that ROS 2's and Foxglove's readers
// take.

#include "musher/view/record/schema.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/recording_file.hpp"

namespace musher::view::schema_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::unique_ptr<mcap::Scan> Recorded(const std::vector<RecordedChannel>& channels,
                                     const std::string& path) {
  const auto file = RecordingFile::Open(path, mcap::Compression::kLz4).value();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    EXPECT_TRUE(file->Write(channels[i], i, 1000, 1000, msg::Encode(msg::String{"hello"})));
  }
  EXPECT_TRUE(file->Close());
  return mcap::Scan::Open(path).value();
}

TEST(RecordedSchema, IsTheDefinitionOfTheTypeWithTheTypesThatItUses) {
  const TempFolder folder;
  const auto scan = Recorded({{"/status", std::string(msg::MachineStatus::kTypeName), "", true}},
                             folder / "a.mcap");
  ASSERT_THAT(scan->schemas(), SizeIs(1));
  const mcap::ScannedSchema& schema = scan->schemas().begin()->second;
  EXPECT_EQ(schema.name, "musher_msgs/msg/MachineStatus");
  EXPECT_EQ(schema.encoding, "ros2msg");
  EXPECT_THAT(schema.data, HasSubstr("uint64 epoch\n"));
  EXPECT_THAT(schema.data, HasSubstr("musher_msgs/ActuatorInfo[] actuators\n"));
  EXPECT_THAT(schema.data, HasSubstr("=\nMSG: musher_msgs/ActuatorInfo\nstring name\n"));
  EXPECT_EQ(schema.data, SchemaText(msg::MachineStatus::kTypeName));
  EXPECT_EQ(scan->channels().begin()->second.schema, scan->schemas().begin()->first);
}

TEST(RecordedSchema, IsInTheFileOnceForTopicsOfTheSameType) {
  const TempFolder folder;
  const std::string type(msg::String::kTypeName);
  const auto scan =
      Recorded({{"/chat", type, "", false}, {"/echo", type, "", false}}, folder / "a.mcap");
  EXPECT_THAT(scan->channels(), SizeIs(2));
  ASSERT_THAT(scan->schemas(), SizeIs(1));
  EXPECT_EQ(scan->schemas().begin()->second.data, "string data\n");
}

TEST(RecordedSchema, OfAnUnknownTypeThereIsNoneAndTheChannelNamesTheType) {
  const TempFolder folder;
  const auto scan = Recorded({{"/own", "my_msgs::msg::dds_::Own_", "", false}}, folder / "a.mcap");
  EXPECT_THAT(scan->schemas(), IsEmpty());
  const mcap::ScannedChannel& channel = scan->channels().begin()->second;
  EXPECT_EQ(channel.schema, 0);
  EXPECT_EQ(channel.metadata.at(kTypeOfUnknown), "my_msgs::msg::dds_::Own_");
}

}  // namespace musher::view::schema_test
