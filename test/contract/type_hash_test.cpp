// The hashes by which ROS 2 compares types: Musher's are rosidl's.

#include "musher/messages/type_hash.hpp"

#include <gmock/gmock.h>

#include <set>
#include <vector>

#include "musher/messages/before_iron.hpp"
#include "musher/messages/rmw_dds_common/participant_entities.hpp"
#include "musher/test/contract/type_hash_table.hpp"

namespace musher::msg::type_hash_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;

// The packages that only Musher ships: there is no other hash of them.
const std::set<std::string> kOwnPackages = {"musher_msgs", "protocol", "plan_msgs", "r2_interfaces",
                                            "action_of_motion_interfaces"};
// Types of ROS 2 that rosidl's hash is not known of.
const std::set<std::string> kNotKnown = {
    "bond/msg/Status", "trajectory_msgs/msg/JointTrajectory",
    "trajectory_msgs/msg/JointTrajectoryPoint",
    // Kilted has a field more at the end than Jazzy, error_msg; the table has Jazzy's.
    "nav2_msgs/action/ComputeRoute_Result", "nav2_msgs/action/ComputeRoute_GetResult_Response",
    "nav2_msgs/action/ComputeAndTrackRoute_Result",
    "nav2_msgs/action/ComputeAndTrackRoute_GetResult_Response"};

// Our types of ROS 2's packages whose hash is not that of the table.
std::vector<std::string> Differences(const HashTable& table) {
  std::vector<std::string> found;
  for (const TypeHash& ours : TypeHashes()) {
    const std::string type = RosTypeName(std::string(ours.type));
    if (kOwnPackages.contains(type.substr(0, type.find('/'))) || kNotKnown.contains(type)) continue;
    const auto row = table.find(type);
    if (row == table.end()) {
      found.push_back(type + ": the table has no row");
    } else if (row->second != ours.hash) {
      found.push_back(type + ": " + std::string(ours.hash) + " is not " + row->second);
    }
  }
  return found;
}

TEST(TypeHashes, AreThoseOfRosidlForEachStandardType) {
  const HashTable table = JazzyTypeHashes();
  ASSERT_GT(table.size(), 100U);
  EXPECT_THAT(Differences(table), IsEmpty());
}

TEST(TypeHashes, DifferFromATableWithAWrongRow) {
  HashTable table = JazzyTypeHashes();
  table["std_msgs/msg/Header"].back() ^= 1;
  EXPECT_THAT(Differences(table), ElementsAre(HasSubstr("std_msgs/msg/Header: RIHS01_")));
}

// The results of nav2's actions had a field less than nav2's: a whole package without rows was
// skipped.
TEST(TypeHashes, DifferFromATableWithoutAPackageOfMusher) {
  HashTable table = JazzyTypeHashes();
  std::erase_if(table, [](const auto& row) { return row.first.starts_with("nav2_msgs/"); });
  EXPECT_THAT(Differences(table),
              ::testing::Contains("nav2_msgs/action/FollowPath_Result: the table has no row"));
}

TEST(TypeHashes, DifferFromATableWithoutARowOfMusher) {
  HashTable table = JazzyTypeHashes();
  table.erase("std_srvs/srv/Trigger_Request");
  EXPECT_THAT(Differences(table),
              ElementsAre("std_srvs/srv/Trigger_Request: the table has no row"));
}

TEST(TypeHashes, ExistForOurOwnMessagesRequestsAndResponses) {
  for (const char* type :
       {"musher_msgs::msg::dds_::MachineStatus_", "musher_msgs::srv::dds_::SetState_Request_",
        "musher_msgs::srv::dds_::SetState_Response_", "protocol::srv::dds_::FsMachine_Request_"}) {
    EXPECT_THAT(std::string(TypeHashOf(type)), MatchesRegex("RIHS01_[0-9a-f]{64}")) << type;
  }
  EXPECT_EQ(TypeHashOf("robot_msgs::msg::dds_::Own_"), "");
}

// Humble and before have no hashes, but another layout.
TEST(NodesOfAParticipant, HaveGidsOfTwentyFourBytesBeforeIron) {
  Gid gid;
  gid.data.fill(7);
  const ParticipantEntitiesInfo info{gid, {{"/dog1", "arm", {gid}, {gid, gid}}}};
  const ParticipantEntitiesInfoBeforeIron older = BeforeIron(info);
  const auto& data = older.node_entities_info_seq.at(0).writer_gid_seq.at(1).data;
  EXPECT_TRUE(std::equal(gid.data.begin(), gid.data.end(), data.begin()));
  EXPECT_EQ(data[16], 0);
  EXPECT_EQ(Encode(older).size(), Encode(info).size() + 4 * 8U);
}

}  // namespace musher::msg::type_hash_test
