// Plans that a lost connection has held up, on a simulated network in virtual time.

#include "musher/modules/meilin/mission/plan_topic.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::meilin::plan_topic_test {

using ::testing::ElementsAre;

class APlanTopic : public ::testing::Test {
 protected:
  APlanTopic() { network_.SetLease(Milliseconds(2000)); }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }
  using Publisher = transport::Publisher<msg::String>;
  static std::unique_ptr<Publisher> MakePublisher(transport::Node& node) {
    return transport::MakePublisher<msg::String>(node, "plans", transport::kLatchedQos).value();
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<std::string> plans_;
  PlanTopic<msg::String> topic_{*robot_, "plans",
                                [this](const msg::String& plan, std::int64_t, bool held_up) {
                                  plans_.push_back(plan.data + (held_up ? " late" : ""));
                                }};
  std::unique_ptr<Publisher> publisher_ = MakePublisher(*desk_);
};

TEST_F(APlanTopic, TakesThoseOfASenderThatHasJustCome) {
  ASSERT_TRUE(publisher_->Publish({"at once"}));
  Run(1000);
  ASSERT_TRUE(publisher_->Publish({"later"}));
  Run(1000);
  const auto other = network_.MakeNode("desk");
  const auto tool = MakePublisher(*other);
  ASSERT_TRUE(tool->Publish({"of another one"}));
  Run(1000);
  EXPECT_THAT(plans_, ElementsAre("at once", "later", "of another one"));
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

}  // namespace musher::meilin::plan_topic_test
