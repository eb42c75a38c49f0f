// The command-line tools of musher-wedding.

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/modules/wedding/second_generation.hpp"
#include "musher/modules/wedding/topic_names.hpp"
#include "musher/test/modules/wedding/wedding_process.hpp"
#include "musher/transport/clock.hpp"

namespace musher::wedding::wedding_tool_test {

using ::testing::HasSubstr;

class WeddingTool : public WeddingProcess {};

// A command for one robot of a DDS domain reached the show of each.
TEST(WeddingTopics, AreInTheNamespaceOfTheMachine) {
  EXPECT_EQ(transport::ResolveName("", topic::kCommand), "wedding/fsm/command");
  for (const std::string name : {topic::kCommand, topic::kReset, topic::kStop, topic::kTarget,
                                 topic::kTooClose, topic::kPose, topic::kPlay, topic::kSetPose}) {
    EXPECT_EQ(transport::ResolveName("bot1", name), "bot1/" + name);
  }
}

TEST_F(WeddingTool, PublishesInputsWithoutRos) {
  StartActive();
  EXPECT_EQ(RunTool({"send", "target", "0.5", "0.4", "--for", "0.3"}), 0) << Said();
  ASSERT_TRUE(AwaitShown("TRACKING"));
  EXPECT_EQ(RunTool({"send", "command", "photo"}), 0) << Said();
  ASSERT_TRUE(AwaitShown("PHOTO_POSING"));
  EXPECT_EQ(RunTool({"send", "too-close", "true", "--json"}), 0) << Said();
  EXPECT_EQ(Said(), "{\"sent\": true}\n");
  ASSERT_TRUE(AwaitShown("SAFE_STOP"));
  EXPECT_EQ(RunTool({"send", "gesture"}), 2);
  EXPECT_EQ(RunTool({"send", "target", "left", "0.4"}), 2);
}

// The tool published once any reader was matched: with a recorder of the topic the show missed it.
TEST_F(WeddingTool, AnInputIsForTheShowAndNotForAnotherReader) {
  int recorded = 0;
  const auto recorder = transport::MakeSubscription<msg::String>(
      peer_.node(), "wedding/fsm/command",
      [&](const msg::String&, const transport::SampleInfo&) { ++recorded; });
  ASSERT_TRUE(recorder);
  EXPECT_EQ(RunTool({"send", "command", "reset"}), 1);
  EXPECT_THAT(Said(), HasSubstr("no show subscribes to wedding/fsm/command"));
  peer_.node().loop().RunUntil([] { return false; }, peer_.node().loop().Now());
  EXPECT_EQ(recorded, 0);
}

TEST_F(WeddingTool, TimesOutOnAClockThatStandsStill) {
  StartActive();
  const auto clock = transport::MakePublisher<msg::Clock>(peer_.node(), transport::kClockTopic,
                                                          transport::kClockQos)
                         .value();
  const auto ticks = peer_.node().loop().Every(Milliseconds(50), [&] {
    static_cast<void>(clock->Publish({{7, 0}}));
  });
  EXPECT_EQ(RunTool({"send", "target", "0.5", "0.4", "--for", "2", "--clock", "topic"}), 1)
      << Said();
  EXPECT_THAT(Said(), HasSubstr("/clock has stood still for 5 s"));
}

TEST_F(WeddingTool, RecordsAndReplaysIdentically) {
  const std::string file = peer_.folder() / "show.toml";
  const std::string record = peer_.folder() / "show.record";
  StartActive(std::string(kFile) + "[record]\nfile = \"show.record\"\n");
  ASSERT_TRUE(gesture_->Publish({"heart"}));
  ASSERT_TRUE(AwaitWithFace("PHOTO_POSING"));
  ASSERT_TRUE(AwaitWithFace("TRACKING"));
  ExpectDone("LowPower");
  ExpectDone("Active");
  ASSERT_TRUE(AwaitWithFace("TRACKING"));
  ExpectDone("TearDown");
  ASSERT_EQ(peer_.AwaitExit(), 0);
  EXPECT_EQ(RunTool({"replay", record, "--config", peer_.folder() / "wedding.toml"}), 0) << Said();
  EXPECT_THAT(Said(), HasSubstr("TRACKING -> PHOTO_POSING  decided"));
  EXPECT_THAT(Said(), HasSubstr("identical"));
  EXPECT_EQ(RunTool({"replay", record}), 1) << "photos of 6 s give a different run";
  EXPECT_THAT(Said(), HasSubstr("show.record:"));
  EXPECT_EQ(RunTool({"replay", file}), 2) << "there is none";
}

}  // namespace musher::wedding::wedding_tool_test
