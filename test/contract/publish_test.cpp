// Publish and subscribe, on every transport.

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/contract/world.hpp"

namespace musher::transport::publish_test {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;
using Strings = std::vector<std::string>;

class Publish : public Contract {
 protected:
  // A subscription that collects its samples.
  std::unique_ptr<Subscription> Collect(Node& node, const std::string& topic, Strings& received,
                                        const Qos& qos = kDefaultQos,
                                        SubscriptionEvents events = {}) {
    return Must(MakeSubscription<msg::String>(
        node, topic,
        [&received](const msg::String& message, const SampleInfo&) {
          received.push_back(message.data);
        },
        qos, std::move(events)));
  }
};
MUSHER_ON_EVERY_TRANSPORT(Publish);

TEST_P(Publish, ReachesASubscriberInAnotherNode) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("chat");
  Strings received;
  const auto subscription = Collect(*there, topic, received);
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  ASSERT_TRUE(publisher->Publish({"hello"}));
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  EXPECT_THAT(received, ElementsAre("hello"));
}

TEST_P(Publish, ReachesASubscriberInTheSameNode) {
  const auto node = MakeNode();
  const std::string topic = Unique("chat");
  Strings received;
  const auto subscription = Collect(*node, topic, received);
  const auto publisher = Must(MakePublisher<msg::String>(*node, topic));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  ASSERT_TRUE(publisher->Publish({"hello"}));
  EXPECT_TRUE(received.empty()) << "callbacks must not run inside Publish()";
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  EXPECT_THAT(received, ElementsAre("hello"));
}

TEST_P(Publish, NamesTheParticipantOfTheSenderAsItNamesItself) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("chat");
  ParticipantId sender = 0;
  const auto subscription = Must(MakeSubscription<msg::String>(
      *there, topic,
      [&sender](const msg::String&, const SampleInfo& info) { sender = info.participant; }));
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  ASSERT_TRUE(publisher->Publish({"hello"}));
  ASSERT_TRUE(RunUntil([&] { return sender != 0; }));
  EXPECT_EQ(sender, here->participant());
}

TEST_P(Publish, GivesALatchedSampleToALateJoiner) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("status");
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic, kLatchedQos));
  ASSERT_TRUE(publisher->Publish({"old"}));
  ASSERT_TRUE(publisher->Publish({"new"}));
  Strings received;
  const auto subscription = Collect(*there, topic, received, kLatchedQos);
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  ASSERT_TRUE(publisher->Publish({"newest"}));
  ASSERT_TRUE(RunUntil([&] { return received.size() == 2; }));
  EXPECT_THAT(received, ElementsAre("new", "newest"));
}

TEST_P(Publish, GivesALateJoinerAsManyLatchedSamplesAsItsDepth) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("events");
  constexpr Qos kThree{Qos::Reliability::kReliable, Qos::Durability::kTransientLocal, 3};
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic, kThree));
  for (const char* text : {"1", "2", "3", "4"}) ASSERT_TRUE(publisher->Publish({text}));
  Strings received;
  const auto subscription = Collect(*there, topic, received, kThree);
  ASSERT_TRUE(RunUntil([&] { return received.size() == 3; }));
  EXPECT_THAT(received, ElementsAre("2", "3", "4"));
}

TEST_P(Publish, GivesALateJoinerTheLatchOfEachOfManyWriters) {
  const auto a = MakeNode(), b = MakeNode(), there = MakeNode();
  const std::string topic = Unique("status");
  const auto first = Must(MakePublisher<msg::String>(*a, topic, kLatchedQos));
  const auto second = Must(MakePublisher<msg::String>(*b, topic, kLatchedQos));
  const auto third = Must(MakePublisher<msg::String>(*b, topic, kLatchedQos));
  ASSERT_TRUE(first->Publish({"first"}));
  ASSERT_TRUE(second->Publish({"second"}));
  ASSERT_TRUE(third->Publish({"third"}));
  Strings received;
  const auto subscription = Collect(*there, topic, received, kLatchedFromManyQos);
  ASSERT_TRUE(RunUntil([&] { return received.size() == 3; }));
  EXPECT_THAT(received, UnorderedElementsAre("first", "second", "third"));
}

TEST_P(Publish, MatchesInPartitionsWhichAReaderOfAllReceives) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("partitioned");
  Qos one = kLatchedQos, other = kLatchedQos, all = kLatchedFromManyQos;
  one.partition = "one";
  other.partition = "other";
  all.partition = kEveryPartition;
  const auto first = Must(MakePublisher<msg::String>(*here, topic, one));
  const auto second = Must(MakePublisher<msg::String>(*here, topic, other));
  ASSERT_TRUE(first->Publish({"1"}));
  ASSERT_TRUE(second->Publish({"2"}));
  Strings received, received_in_one, received_in_none;
  const auto of_all = Must(MakeSubscription<msg::String>(
      *there, topic,
      [&](const msg::String& message, const SampleInfo& info) {
        received.push_back(message.data + " in " + std::string(info.partition.value_or("none")));
      },
      all));
  const auto of_one = Collect(*there, topic, received_in_one, one);
  const auto of_none = Collect(*there, topic, received_in_none, kLatchedQos);
  ASSERT_TRUE(RunUntil([&] { return received.size() == 2 && !received_in_one.empty(); }));
  EXPECT_THAT(received, UnorderedElementsAre("1 in one", "2 in other"));
  EXPECT_THAT(received_in_one, ElementsAre("1"));
  EXPECT_THAT(received_in_none, ElementsAre());
}

TEST_P(Publish, KeepsTheOrderOfAWriter) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("count");
  constexpr Qos kAll{Qos::Reliability::kReliable, Qos::Durability::kVolatile, 0};
  Strings received, sent;
  const auto subscription = Collect(*there, topic, received, kAll);
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic, kAll));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  for (int i = 0; i < 200; ++i) {
    sent.push_back(std::to_string(i));
    ASSERT_TRUE(publisher->Publish({sent.back()}));
  }
  ASSERT_TRUE(RunUntil([&] { return received.size() >= sent.size(); }));
  EXPECT_EQ(received, sent);
}

TEST_P(Publish, CarriesASampleOfAMegabyte) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("image");
  Strings received;
  const auto subscription = Collect(*there, topic, received);
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  std::string large(1 << 20, ' ');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>('a' + i * 7 % 26);
  ASSERT_TRUE(publisher->Publish({large}));
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  EXPECT_TRUE(received.front() == large);
}

TEST_P(Publish, DropsAndCountsAMalformedSample) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("chat");
  Strings received;
  const auto subscription = Collect(*there, topic, received);
  const auto writer =
      Must(here->MakeRawWriter("rt/" + topic, std::string(msg::String::kTypeName), {}, {}));
  ASSERT_TRUE(RunUntil([&] { return writer->MatchedReaders() == 1; }));
  const msg::Bytes good = msg::Encode(msg::String{"good"});
  ASSERT_TRUE(writer->Write({good.begin(), good.end() - 4}));
  ASSERT_TRUE(writer->Write(good));
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  EXPECT_THAT(received, ElementsAre("good"));
  EXPECT_EQ(subscription->malformed(), 1u);
}

TEST_P(Publish, DoesNotMatchATopicOfAnotherType) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("chat");
  Strings received;
  const auto other = Must(here->MakeRawWriter("rt/" + topic, "other::msg::dds_::Type_", {}, {}));
  const auto subscription = Collect(*there, topic, received);
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  ASSERT_TRUE(publisher->Publish({"hello"}));
  ASSERT_TRUE(RunUntil([&] { return !received.empty(); }));
  EXPECT_EQ(other->MatchedReaders(), 0);
  EXPECT_EQ(subscription->MatchedWriters(), 1);
}

TEST_P(Publish, ReportsTheWriterOfASample) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("chat");
  std::vector<SampleInfo> from;
  const auto subscription = Must(MakeSubscription<msg::String>(
      *there, topic, [&](const msg::String&, const SampleInfo& info) { from.push_back(info); }));
  const auto first = Must(MakePublisher<msg::String>(*here, topic));
  const auto second = Must(MakePublisher<msg::String>(*here, topic));
  for (const auto* publisher : {&first, &second}) {
    ASSERT_TRUE(RunUntil([&] { return (*publisher)->MatchedReaders() == 1; }));
    ASSERT_TRUE((*publisher)->Publish({"hello"}));
    const std::size_t before = from.size();
    ASSERT_TRUE(RunUntil([&] { return from.size() == before + 1; }));
  }
  EXPECT_NE(from[0].writer, from[1].writer);
  EXPECT_EQ(from[0].participant, from[1].participant);
}

TEST_P(Publish, ReportsALostWriterAfterItsLastSample) {
  auto here = MakeNode();
  const auto there = MakeNode();
  const std::string topic = Unique("status");
  EndpointId writer = 0, lost = 0;
  Strings received;
  SubscriptionEvents events;
  events.on_writer_lost = [&](EndpointId peer) {
    EXPECT_EQ(received.size(), 1u);
    lost = peer;
  };
  const auto subscription = Must(MakeSubscription<msg::String>(
      *there, topic,
      [&](const msg::String& message, const SampleInfo& info) {
        received.push_back(message.data);
        writer = info.writer;
      },
      kLatchedQos, std::move(events)));
  auto publisher = Must(MakePublisher<msg::String>(*here, topic, kLatchedQos));
  ASSERT_TRUE(RunUntil(
      [&] { return publisher->MatchedReaders() == 1 && subscription->MatchedWriters() == 1; }));
  ASSERT_TRUE(publisher->Publish({"last words"}));
  publisher.reset();
  here.reset();
  ASSERT_TRUE(RunUntil([&] { return lost != 0; }));
  EXPECT_EQ(lost, writer);
  EXPECT_EQ(subscription->MatchedWriters(), 0);
}

TEST_P(Publish, LetsACallbackDropItsOwnSubscription) {
  const auto here = MakeNode(), there = MakeNode();
  const std::string topic = Unique("chat");
  int received = 0;
  std::unique_ptr<Subscription> subscription;
  subscription =
      Must(MakeSubscription<msg::String>(*there, topic, [&](const msg::String&, const SampleInfo&) {
        ++received;
        subscription.reset();
      }));
  const auto publisher = Must(MakePublisher<msg::String>(*here, topic));
  ASSERT_TRUE(RunUntil([&] { return publisher->MatchedReaders() == 1; }));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(publisher->Publish({"hello"}));
  ASSERT_TRUE(RunUntil([&] { return received > 0 && publisher->MatchedReaders() == 0; }));
  EXPECT_EQ(received, 1);
}

}  // namespace musher::transport::publish_test
