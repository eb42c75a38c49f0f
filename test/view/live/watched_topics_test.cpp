// In virtual time: what a page gets of a topic that several writers publish.

#include "musher/view/live/watched_topics.hpp"

#include <gmock/gmock.h>

#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::view::watched_topics_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

class WatchedSkills : public ::testing::Test {
 protected:
  struct Robot {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::SkillOffers>> skills;
  };

  Robot Start(const std::string& name) {
    Robot robot{network_.MakeNode(name), nullptr};
    robot.skills =
        transport::MakePublisher<msg::SkillOffers>(*robot.node, "skills", transport::kLatchedQos)
            .value();
    EXPECT_TRUE(robot.skills->Publish({name, "/" + name + "/skill_execution", {}}).ok());
    return robot;
  }
  void Find() { Find<msg::SkillOffers>("skills", transport::Qos::Durability::kTransientLocal); }
  template <class M>
  void Find(const std::string& topic, transport::Qos::Durability durability) {
    transport::DiscoveredEndpoint found;
    found.id = 1;
    found.writer = true;
    found.topic = "rt/" + topic;
    found.type = std::string(M::kTypeName);
    found.durability = durability;
    table_.OnFound(found);
    watched_.Watch({"/" + topic});
    network_.RunFor(std::chrono::seconds(1));
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  TopicTable table_;
  std::vector<std::string> messages_;
  std::set<std::string> topics_;
  std::set<std::string> keys_;
  WatchedTopics watched_{*desk_, table_,
                         [this](const std::string& topic, const WatchedTopics::Latest& latest) {
                           topics_.insert(topic);
                           messages_.push_back(*latest.message);
                           keys_.insert(latest.key);
                         }};
};

TEST_F(WatchedSkills, OfFourWritersReachThePageAll) {
  std::vector<Robot> robots;
  for (const std::string name : {"ann", "ben", "cid", "dot"}) robots.push_back(Start(name));
  Find();
  EXPECT_THAT(messages_, UnorderedElementsAre(HasSubstr("/ann/"), HasSubstr("/ben/"),
                                              HasSubstr("/cid/"), HasSubstr("/dot/")));
  EXPECT_THAT(topics_, ::testing::ElementsAre("/skills"));
  EXPECT_THAT(keys_, SizeIs(4)) << "one must not replace another one in the queue of a slow page";
  EXPECT_THAT(watched_.Last("/skills"), SizeIs(4)) << "for a page that opens later";
}

TEST_F(WatchedSkills, OfARestartedWriterReplaceTheOldOnes) {
  std::optional<Robot> ann = Start("ann");
  const Robot ben = Start("ben");
  Find();
  for (int i = 0; i < 5; ++i) {
    ann.reset();
    network_.RunFor(std::chrono::seconds(1));
    EXPECT_THAT(watched_.Last("/skills"), SizeIs(2)) << "the last word of a lost writer stays";
    ann = Start("ann");
    network_.RunFor(std::chrono::seconds(1));
  }
  EXPECT_THAT(watched_.Last("/skills"), SizeIs(2));
  EXPECT_THAT(*watched_.Last("/skills").back().message, HasSubstr("/ann/"));
  EXPECT_THAT(keys_, SizeIs(2));
}

TEST_F(WatchedSkills, OfMoreWritersThanAreKeptCostNoMoreMemory) {
  std::vector<Robot> robots;
  for (std::size_t i = 0; i < WatchedTopics::kMostSamples + 10; ++i) {
    robots.push_back(Start("robot" + std::to_string(i)));
  }
  Find();
  EXPECT_THAT(watched_.Last("/skills"), SizeIs(WatchedTopics::kMostSamples));
}

TEST_F(WatchedSkills, ThatOneRobotReportsAtTheSameTimeReachThePageBoth) {
  const auto robot = network_.MakeNode("ann");
  const auto feedback =
      transport::MakePublisher<msg::SkillFeedback>(*robot, "skill_feedback").value();
  Find<msg::SkillFeedback>("skill_feedback", transport::Qos::Durability::kVolatile);
  for (const std::uint8_t status :
       {msg::SkillFeedback::kStatusProcessing, msg::SkillFeedback::kStatusCompleted}) {
    for (const char* skill : {"lift", "turn"}) {
      msg::SkillFeedback report;
      report.actuator = "ann";
      report.skill = skill;
      report.status = status;
      ASSERT_TRUE(feedback->Publish(report).ok());
    }
  }
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(messages_,
              UnorderedElementsAre(AllOf(HasSubstr("\"lift\""), HasSubstr("\"status\":1")),
                                   AllOf(HasSubstr("\"turn\""), HasSubstr("\"status\":1"))))
      << "of each skill the newest";
  EXPECT_THAT(keys_, SizeIs(2));
}

TEST_F(WatchedSkills, AreNoneBeforeThereIsAWriter) {
  EXPECT_THAT(watched_.Last("/skills"), IsEmpty());
  Find();
  EXPECT_THAT(messages_, IsEmpty());
}

}  // namespace musher::view::watched_topics_test
