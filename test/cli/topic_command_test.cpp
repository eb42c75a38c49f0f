// `musher topic` beside a node with topics.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/json_schema.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/node.hpp"

namespace musher::cli::topic_command_test {

using ::testing::AllOf;
using testing::Ended;
using ::testing::HasSubstr;
using testing::Process;

const std::string kMusher = BinDir() + "/musher";

// A process of its own: the participant of this one is not among those that it discovers.
Ended Musher(const std::vector<std::string>& arguments) {
  std::vector<std::string> argv = {kMusher};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  Ended ended = testing::RunToEnd(argv);
  testing::CheckDocuments(arguments, ended.out);
  return ended;
}

// The same, until it prints a line with `part` (a regular expression): discovery ends when nothing
// was discovered for some 100 ms, on a busy computer at times too early.
Ended MusherUntil(const std::vector<std::string>& arguments, const std::string& part) {
  Ended ended;
  testing::Until([&] {
    ended = Musher(arguments);
    return ::testing::Value(ended.out, ::testing::ContainsRegex(part));
  });
  return ended;
}

class TopicCommand : public ::testing::Test {
 protected:
  TopicCommand() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    transport::DdsOptions options;
    options.node_name = "talker";
    options.name_space = "dog1";
    thread_ = transport::NodeThread::Start(options).value();
  }
  ~TopicCommand() override {
    thread_->RunOnLoop([this] {
      ticks_.reset();
      own_.reset();
      publishers_.clear();
      reader_.reset();
    });
  }
  TopicCommand(const TopicCommand&) = delete;
  TopicCommand& operator=(const TopicCommand&) = delete;

  // A topic with its samples so far.
  void Offer(const std::string& topic, const std::vector<std::string>& samples = {},
             const transport::Qos& qos = transport::kLatchedQos) {
    thread_->RunOnLoop([&] {
      publishers_.push_back(
          transport::MakePublisher<msg::String>(thread_->node(), topic, qos).value());
      msg::String message;
      for (const std::string& sample : samples) {
        message.data = sample;
        EXPECT_TRUE(publishers_.back()->Publish(message));
      }
    });
  }
  // The topics that were offered get a sample each time.
  void PublishEvery(Duration period) {
    thread_->RunOnLoop([&] {
      ticks_ = thread_->node().loop().Every(period, [this] {
        for (const auto& publisher : publishers_) static_cast<void>(publisher->Publish({"tick"}));
      });
    });
  }
  void Read(const std::string& topic) {
    thread_->RunOnLoop([&] {
      reader_ = transport::MakeSubscription<msg::String>(thread_->node(), topic,
                                                         [](const msg::String&, const auto&) {})
                    .value();
    });
  }
  void OfferUnknownType(const std::string& topic) {
    thread_->RunOnLoop([&] {
      own_ =
          thread_->node()
              .MakeRawWriter("rt/" + topic, "my_msgs::msg::dds_::Own_", transport::kLatchedQos, {})
              .value();
      EXPECT_TRUE(own_->Write(msg::Encode(msg::String{"?"})));
    });
  }

 private:
  std::shared_ptr<transport::NodeThread> thread_;
  std::vector<std::unique_ptr<transport::Publisher<msg::String>>> publishers_;
  std::unique_ptr<transport::Subscription> reader_;
  std::unique_ptr<transport::RawWriter> own_;
  transport::LoopHandlePtr ticks_;
};

nlohmann::json Json(const std::string& text) {
  return nlohmann::json::parse(text, nullptr, false);
}

TEST_F(TopicCommand, ListsTheTopicsWithTheirTypesWritersAndReaders) {
  Offer("dog1/chat");
  Read("dog1/chat");
  const std::string row = "/dog1/chat +1 +1 +std_msgs/msg/String\n";
  const Ended ran = MusherUntil({"topic", "list"}, row);
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out, ::testing::ContainsRegex(row));
  const Ended json = MusherUntil({"topic", "list", "--json"}, "/dog1/chat");
  const nlohmann::json topics = Json(json.out)["topics"];
  bool found = false;
  for (const auto& topic : topics) {
    if (topic["topic"] != "/dog1/chat") continue;
    found = true;
    EXPECT_EQ(topic["type"], "std_msgs/msg/String");
    EXPECT_EQ(topic["writers"], 1);
  }
  EXPECT_TRUE(found) << json.out;
}

TEST_F(TopicCommand, ShowsTheNodesOfATopicWithTheirQosAndWhoReceivesNothing) {
  Offer("dog1/chat", {}, transport::kSensorDataQos);
  Read("dog1/chat");
  const Ended ran =
      MusherUntil({"--namespace", "dog1", "topic", "info", "chat"}, "receives nothing of /dog1/");
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_THAT(ran.out,
              AllOf(HasSubstr("/dog1/chat  std_msgs/msg/String\n"),
                    ::testing::ContainsRegex("writer +/dog1/talker +[0-9]+ on .* +best effort"),
                    HasSubstr("reader /dog1/talker receives nothing of /dog1/talker: it "
                              "requests reliable samples")));
  const Ended json =
      MusherUntil({"topic", "info", "/dog1/chat", "--json"}, "/dog1/talker.*/dog1/talker");
  const auto info = Json(json.out);
  EXPECT_EQ(info["writers"][0]["node"], "/dog1/talker") << json.out;
  EXPECT_EQ(info["writers"][0]["reliability"], "best_effort");
  EXPECT_EQ(info["readers"][0]["durability"], "volatile");
}

TEST_F(TopicCommand, EchoPrintsTheLatchedSampleOfATopic) {
  Offer("chat", {"hello"});
  const Ended ran = Musher({"topic", "echo", "/chat", "--samples", "1"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  EXPECT_EQ(ran.out, "data: hello\n---\n");
  const Ended json = Musher({"topic", "echo", "/chat", "--samples", "1", "--json"});
  EXPECT_EQ(Json(json.out)["sample"]["data"], "hello") << json.out;
  EXPECT_EQ(Json(json.out)["type"], "std_msgs/msg/String");
}

TEST_F(TopicCommand, EchoPrintsEverySampleUntilCtrlC) {
  Offer("chat", {"hello"});
  PublishEvery(Milliseconds(20));
  Process echo({kMusher, "topic", "echo", "chat"});
  ASSERT_NE(echo.LineWith("data: tick"), "");
  ASSERT_NE(echo.LineWith("data: tick"), "");
  echo.Signal(SIGINT);
  EXPECT_EQ(echo.Wait().exit, 0);
}

TEST_F(TopicCommand, OfAnUnknownTopicTheNearestIsNamed) {
  Offer("chat");
  for (const char* command : {"echo", "hz", "info"}) {
    const Ended ran = Musher({"topic", command, "/chta"});
    EXPECT_EQ(ran.exit, 2) << command;
    EXPECT_THAT(ran.err, HasSubstr("there is no topic '/chta'; did you mean '/chat'?"));
  }
}

TEST_F(TopicCommand, ATopicOnWhichNothingIsPublishedIsNotWaitedForForEver) {
  Offer("chat");
  Read("silent");
  const Ended echo = Musher({"topic", "echo", "chat", "--timeout", "0.3"});
  EXPECT_EQ(echo.exit, 1);
  EXPECT_EQ(echo.err,
            "musher: nothing was published on /chat within 0.3 s: its writer is silent; `musher "
            "topic info /chat` shows it\n");
  const Ended hz = Musher({"topic", "hz", "silent", "--timeout", "0.3"});
  EXPECT_EQ(hz.exit, 1);
  EXPECT_THAT(hz.err, HasSubstr("it has no writer, only 1 reader"));
}

TEST_F(TopicCommand, ATypeThatMusherDoesNotKnowIsNamed) {
  OfferUnknownType("own");
  const Ended ran = Musher({"topic", "echo", "own"});
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.err, HasSubstr("/own has the type my_msgs/msg/Own, which Musher does not know"));
}

TEST_F(TopicCommand, HzMeasuresTheRateOfATopic) {
  Offer("chat", {"old"});
  PublishEvery(Milliseconds(10));
  const Ended ran = Musher({"topic", "hz", "chat", "--for", "3", "--json"});
  EXPECT_EQ(ran.exit, 0) << ran.err;
  const auto json = Json(ran.out);
  EXPECT_GE(json["samples"], 2) << ran.out;
  EXPECT_GT(json["rate_hz"], 0.0);
  EXPECT_LE(json["min_s"], json["max_s"]);
}

TEST_F(TopicCommand, CompletionOffersTheTopicsWithTheirTypes) {
  Offer("chat");
  const std::string offered = "/chat\tstd_msgs/msg/String\n";
  EXPECT_THAT(MusherUntil({"complete", "topic", "echo", "/ch"}, offered).out, HasSubstr(offered));
}

}  // namespace musher::cli::topic_command_test
