// Plans that have waited at their sender, on a simulated network in virtual time.

#include "musher/modules/meilin/mission/plan_topic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/transport/node_with_peers.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::meilin::plan_topic_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class APlanTopic : public ::testing::Test {
 protected:
  APlanTopic() { network_.SetLease(Milliseconds(2000)); }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }
  using Publisher = transport::Publisher<msg::String>;
  static std::unique_ptr<Publisher> MakePublisher(transport::Node& node) {
    return transport::MakePublisher<msg::String>(node, "plans", transport::kLatchedQos).value();
  }

  transport::sim::Network network_{1};
  musher::testing::NodeWithPeers robot_{network_.MakeNode("robot")};
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<std::string> plans_;
  std::string late_;  // of the last one
  PlanTopic<msg::String> topic_{
      robot_, "plans", [this](const msg::String& plan, std::int64_t, const std::string& late) {
        plans_.push_back(plan.data + (late.empty() ? "" : " late"));
        late_ = late;
      }};
  std::unique_ptr<Publisher> publisher_ = MakePublisher(*desk_);
};

TEST_F(APlanTopic, TakesThoseOfASenderThatHasBeenConnectedForSomeSeconds) {
  Run(6000);
  ASSERT_TRUE(publisher_->Publish({"first"}));
  Run(1000);
  ASSERT_TRUE(publisher_->Publish({"second"}));
  Run(1000);
  EXPECT_THAT(plans_, ElementsAre("first", "second"));
}

// People had entered the field, and the robot drove.
TEST_F(APlanTopic, KnowsThatAPlanMayBeAsOldAsTheLossOfItsSender) {
  Run(1000);
  network_.Partition("robot", "desk");
  Run(10'000);
  ASSERT_TRUE(publisher_->Publish({"sent without a link"}));
  Run(240'000);
  EXPECT_THAT(plans_, ElementsAre());
  network_.Heal("robot", "desk");
  Run(6000);
  EXPECT_THAT(plans_, ElementsAre("sent without a link late"));
  ASSERT_TRUE(publisher_->Publish({"sent once more"}));
  Run(1000);
  EXPECT_EQ(plans_.back(), "sent once more");
}

// A planner that had run for an hour came into reach during a match.
TEST_F(APlanTopic, DoesNotTakeTheFirstPlanOfASenderThatWasNotKnownForNew) {
  network_.Partition("robot", "planner");
  const auto planner = network_.MakeNode("planner");
  const auto plans = MakePublisher(*planner);
  ASSERT_TRUE(plans->Publish({"an hour ago"}));
  Run(3'600'000);
  EXPECT_THAT(plans_, ElementsAre());
  network_.Heal("robot", "planner");
  Run(8000);
  EXPECT_THAT(plans_, ElementsAre("an hour ago late"));
  EXPECT_EQ(late_, kSenderHasJustConnected);
  ASSERT_TRUE(plans->Publish({"sent once more"}));
  Run(1000);
  EXPECT_EQ(plans_.back(), "sent once more");
}

// The wall clock of the simulation began in 1970.
TEST_F(APlanTopic, ChecksWhenTheFirstPlanOfASenderOnThisComputerWasWritten) {
  transport::PeerInfo desk;
  desk.id = network_.ParticipantOf(*desk_);
  desk.host = HostName();
  robot_.peers = {desk};
  Run(1000);
  ASSERT_TRUE(publisher_->Publish({"of 1970"}));
  Run(1000);
  EXPECT_THAT(plans_, ElementsAre("of 1970 late"));
  EXPECT_THAT(late_, HasSubstr("it was written "));
}

TEST(APlanOfASenderThatHasJustConnected, IsNewWhereThisComputerHasWrittenItJustNow) {
  EXPECT_EQ(WhyMayBeLate(Milliseconds(3)), "");
  EXPECT_EQ(WhyMayBeLate(Milliseconds(5000)), "");
  EXPECT_EQ(WhyMayBeLate(-Milliseconds(100)), "") << "a clock that is slewed";
}

TEST(APlanOfASenderThatHasJustConnected, IsLateWithItsAgeWhereThisComputerHasWrittenItBefore) {
  EXPECT_EQ(WhyMayBeLate(std::chrono::hours(1)),
            "it was written 3600 s before its sender has connected: look at the robot, then send "
            "it once more");
}

TEST(APlanOfASenderThatHasJustConnected, MayBeLateWhereItsAgeIsNotKnown) {
  EXPECT_EQ(WhyMayBeLate(std::nullopt), kSenderHasJustConnected);
  EXPECT_EQ(WhyMayBeLate(-std::chrono::hours(1)), kSenderHasJustConnected)
      << "the clock was set back";
}

class ThePlanSenders : public ::testing::Test {
 protected:
  static constexpr transport::ParticipantId kDesk{1};

  PlanSenders senders_;
  Time now_ = Time() + std::chrono::hours(1);
};

TEST_F(ThePlanSenders, AreKnownSomeSecondsAfterTheyHaveConnected) {
  EXPECT_TRUE(senders_.HasJustConnected(kDesk, now_)) << "its plan comes before its connection";
  senders_.OnConnected({kDesk}, now_);
  EXPECT_TRUE(senders_.HasJustConnected(kDesk, now_));
  now_ += PlanSenders::kJustConnected;
  EXPECT_FALSE(senders_.HasJustConnected(kDesk, now_));
  senders_.OnConnected({kDesk, transport::ParticipantId(2)}, now_);
  EXPECT_FALSE(senders_.HasJustConnected(kDesk, now_)) << "another one has connected";
}

// A planner that is respawned every second filled the memory of the match, an entry each time.
TEST_F(ThePlanSenders, AreForgottenWithTheirConnection) {
  for (std::uint64_t id = 1; id <= 10'000; ++id) {
    senders_.OnConnected({kDesk, transport::ParticipantId(id + 1)}, now_);
    now_ += std::chrono::seconds(1);
    senders_.OnConnected({kDesk}, now_);
    ASSERT_EQ(senders_.size(), 1U);
  }
  EXPECT_FALSE(senders_.HasJustConnected(kDesk, now_));
  EXPECT_TRUE(senders_.HasJustConnected(transport::ParticipantId(2), now_));
}

}  // namespace musher::meilin::plan_topic_test
