#include "musher/view/topics/topic_table.hpp"

#include <gmock/gmock.h>

namespace musher::view::topic_table_test {

using transport::DiscoveredEndpoint;
using transport::Qos;

DiscoveredEndpoint Endpoint(transport::EndpointId id, bool writer, const std::string& topic,
                            Qos::Reliability reliability = Qos::Reliability::kReliable,
                            Qos::Durability durability = Qos::Durability::kVolatile) {
  DiscoveredEndpoint endpoint;
  endpoint.id = id;
  endpoint.writer = writer;
  endpoint.topic = topic;
  endpoint.type = "std_msgs::msg::dds_::String_";
  endpoint.reliability = reliability;
  endpoint.durability = durability;
  return endpoint;
}

TEST(TopicTableTest, CountsWritersAndReadersOfATopic) {
  TopicTable table;
  EXPECT_TRUE(table.OnFound(Endpoint(1, true, "rt/chat")));
  EXPECT_TRUE(table.OnFound(Endpoint(2, false, "rt/chat")));
  EXPECT_TRUE(table.OnFound(Endpoint(3, false, "rt/chat")));
  const ListedTopic chat{"/chat", "std_msgs/msg/String", "std_msgs::msg::dds_::String_", 1, 2};
  EXPECT_THAT(table.List(), ::testing::ElementsAre(chat));
  EXPECT_TRUE(table.OnLost(1));
  EXPECT_FALSE(table.OnLost(1));
  EXPECT_EQ(table.List().front().publishers, 0U);
}

TEST(TopicTableTest, LeavesOutRequestsAndReplies) {
  TopicTable table;
  EXPECT_FALSE(table.OnFound(Endpoint(1, true, "rq/resetRequest")));
  EXPECT_FALSE(table.OnFound(Endpoint(2, true, "rr/resetReply")));
  EXPECT_THAT(table.List(), ::testing::IsEmpty());
}

TEST(TopicTableTest, HasAQosThatMatchesEveryWriter) {
  TopicTable table;
  EXPECT_EQ(table.SourceOf("/chat"), std::nullopt);
  table.OnFound(
      Endpoint(1, true, "rt/chat", Qos::Reliability::kReliable, Qos::Durability::kTransientLocal));
  EXPECT_EQ(table.SourceOf("/chat")->qos.durability, Qos::Durability::kTransientLocal);
  table.OnFound(Endpoint(2, true, "rt/chat", Qos::Reliability::kBestEffort));
  EXPECT_EQ(table.SourceOf("/chat")->qos.durability, Qos::Durability::kVolatile);
  EXPECT_EQ(table.SourceOf("/chat")->qos.reliability, Qos::Reliability::kBestEffort);
  table.OnFound(Endpoint(3, false, "rt/other"));
  EXPECT_EQ(table.SourceOf("/other"), std::nullopt) << "a reader is no source";
}

}  // namespace musher::view::topic_table_test
