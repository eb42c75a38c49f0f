// The recorder of topics on the simulated transport.

#include "musher/view/record/topic_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/view/record/fake_sink.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/view/record/qos_text.hpp"

namespace musher::view::topic_recorder_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using transport::Qos;

class Recording : public ::testing::Test {
 protected:
  Recording() { Choose({}); }

  void Choose(const std::vector<std::string>& topics) {
    recorder_ = std::make_unique<TopicRecorder>(
        *desk_, TopicChoice::Of(topics, {}, "").value(), sink_, [this] { return wall_ns_; },
        [this](const std::string& sentence) { sentences_.push_back(sentence); });
  }
  // A publisher of the robot, as discovery reports it.
  std::unique_ptr<transport::Publisher<msg::String>> Publish(const std::string& topic, Qos qos) {
    auto publisher = transport::MakePublisher<msg::String>(*dog_, topic, qos).value();
    recorder_->OnFound({++id_, "rt/" + topic, std::string(msg::String::kTypeName), qos});
    network_.RunFor(std::chrono::seconds(1));
    return publisher;
  }
  void Say(transport::Publisher<msg::String>& publisher, const std::string& text) {
    msg::String message;
    message.data = text;
    ASSERT_TRUE(publisher.Publish(message));
    network_.RunFor(Milliseconds(100));
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> dog_ = network_.MakeNode("dog");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::int64_t wall_ns_ = 1'780'000'000'000'000'000;
  transport::EndpointId id_ = 0;
  FakeSink sink_;
  std::vector<std::string> sentences_;
  std::unique_ptr<TopicRecorder> recorder_;
};

TEST_F(Recording, EachSampleIsRecordedAsItWasSentWithTheTimeOfItsReceipt) {
  auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  wall_ns_ += 5;
  Say(*chat, "again");
  ASSERT_THAT(sink_.channels, SizeIs(1));
  EXPECT_EQ(sink_.channels[0].topic, "/chat");
  EXPECT_EQ(sink_.channels[0].type, msg::String::kTypeName);
  ASSERT_THAT(sink_.samples, SizeIs(2));
  msg::String hello;
  hello.data = "hello";
  EXPECT_EQ(sink_.samples[0].data, msg::Encode(hello));
  EXPECT_EQ(sink_.samples[1].log_ns, sink_.samples[0].log_ns + 5);
  EXPECT_EQ(recorder_->Counts().at("/chat").messages, 2U);
}

TEST_F(Recording, ALatchedSampleFromBeforeTheRecordingIsRecorded) {
  auto state = transport::MakePublisher<msg::String>(*dog_, "state", transport::kLatchedQos);
  Say(*state.value(), "Active");
  recorder_->OnFound(
      {++id_, "rt/state", std::string(msg::String::kTypeName), transport::kLatchedQos});
  network_.RunFor(std::chrono::seconds(1));
  ASSERT_THAT(sink_.samples, SizeIs(1));
  EXPECT_TRUE(sink_.channels[0].latched);
  EXPECT_THAT(sink_.channels[0].offered_qos, HasSubstr("durability: transient_local"));
}

TEST_F(Recording, ATopicIsRecordedFromWritersOfDifferentQos) {
  auto strict = Publish("chat", transport::kLatchedQos);
  Say(*strict, "one");
  auto loose = Publish("chat", transport::kSensorDataQos);
  Say(*loose, "two");
  Say(*strict, "three");
  EXPECT_THAT(sink_.samples, SizeIs(3));
  EXPECT_THAT(sink_.channels, SizeIs(1));
}

TEST_F(Recording, ATopicWhoseWriterComesBackIsStillRecorded) {
  auto first = Publish("chat", transport::kDefaultQos);
  Say(*first, "one");
  recorder_->OnLost(id_);
  first.reset();
  auto second = Publish("chat", transport::kDefaultQos);
  Say(*second, "two");
  EXPECT_THAT(sink_.samples, SizeIs(2));
}

TEST_F(Recording, OtherTopicsAreNotRecorded) {
  Choose({"/camera/*"});
  auto chat = Publish("chat", transport::kDefaultQos);
  auto image = Publish("camera/left", transport::kDefaultQos);
  Say(*chat, "hello");
  Say(*image, "picture");
  ASSERT_THAT(sink_.samples, SizeIs(1));
  EXPECT_EQ(sink_.channels[0].topic, "/camera/left");
  EXPECT_THAT(recorder_->choice().Unmatched(), IsEmpty());
}

TEST_F(Recording, WhatTheDiskHasNoRoomForIsCountedAsLost) {
  auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "one");
  sink_.full = true;
  Say(*chat, "two");
  EXPECT_EQ(recorder_->Counts().at("/chat").messages, 1U);
  EXPECT_EQ(recorder_->Counts().at("/chat").lost, 1U);
}

TEST_F(Recording, AfterItsEndNothingIsRecordedOrCounted) {
  auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "one");
  recorder_->Stop();
  Say(*chat, "two");
  EXPECT_THAT(sink_.samples, SizeIs(1));
  EXPECT_EQ(recorder_->Counts().at("/chat").messages, 1U);
}

}  // namespace musher::view::topic_recorder_test
