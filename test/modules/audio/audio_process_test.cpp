// musher-audio-manager as a controller drives it, and musher-audio: the real programs over DDS.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/audio/sound_file.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/transport/clock.hpp"

namespace musher::audio::audio_process_test {

using ::testing::HasSubstr;

const std::string kPhrases = "phrases = \"" + SourceDir() + "/config/audio/phrases.toml\"\n";
const std::string kWav = "output = \"wav\"\nfolder = \"spoken\"\n" + kPhrases;

// Some eight seconds.
const std::string kLongText =
    "One two three four five six seven eight nine ten eleven twelve thirteen. "
    "And all of it once more, since it is a long way to go with so few words on a day like this.";

using Answer = std::optional<Result<msg::AudioTextPlay::Response>>;
using Response = msg::AudioTextPlay::Response;

class AudioManagerProcess : public test::ModuleProcess {
 protected:
  AudioManagerProcess() : ModuleProcess("audio", "musher-audio-manager") {}

  void Start(const std::string& file) {
    ASSERT_NO_FATAL_FAILURE(ModuleProcess::Start(file));
    OpenTopics();
  }
  // On the time of a world, which begins to publish it.
  void StartInAWorld(const std::string& file) {
    ASSERT_NO_FATAL_FAILURE(StartOnWorldTime(file));
    OpenTopics();
    world_ = Publisher<msg::Clock>("clock", transport::kClockQos);
    ticker_ = peer_.node().loop().Every(Milliseconds(5), [this] {
      static_cast<void>(world_->Publish({msg::ToStamp(world_time_ += world_step_)}));
    });
  }

  void OpenTopics() {
    text_ = transport::MakeClient<msg::AudioTextPlay>(peer_.node(), "speech_text_play").value();
    play_ = Publisher<msg::AudioPlay>("speech_play");
    Subscribe<msg::Bool>("audio_notification_report",
                         [this](const msg::Bool& report) { sounds_ = report.data; });
    ASSERT_TRUE(peer_.Until([this] {
      return text_->Ready() && play_->MatchedReaders() > 0 &&
             subscriptions_.back()->MatchedWriters() > 0;
    }));
  }
  void RequestText(const msg::AudioTextPlay::Request& request, Answer& answer) {
    text_->Call(request, std::chrono::seconds(120), [&answer](auto reply) { answer = reply; });
  }
  void Say(const std::string& text, Answer& answer) {
    RequestText({"test", true, {}, text}, answer);
  }
  // The final reply.
  Response Await(const Answer& answer) {
    const bool there = peer_.Until([&] { return answer.has_value(); });
    EXPECT_TRUE(there && *answer) << peer_.Output();
    return there && *answer ? answer->value() : Response{255, -1};
  }
  // Waits for a log line that begins so: what plays may still be the sound before.
  bool AwaitWords(const std::string& words) { return AwaitOutput("plays \"" + words); }
  Response ReplyTo(const std::string& text) {
    Answer answer;
    Say(text, answer);
    return Await(answer);
  }
  std::string Spoken(const std::string& name) const { return peer_.folder() / ("spoken/" + name); }

  bool sounds_ = false;
  Duration world_time_ = std::chrono::seconds(1'000);
  Duration world_step_{};  // of each 5 ms
  std::unique_ptr<transport::Publisher<msg::Clock>> world_;
  std::unique_ptr<transport::Client<msg::AudioTextPlay>> text_;
  std::unique_ptr<transport::Publisher<msg::AudioPlay>> play_;
  transport::LoopHandlePtr ticker_;
};

TEST_F(AudioManagerProcess, AnswersATextWhenItsSoundHasEnded) {
  Start(kWav);
  const Time begun = std::chrono::steady_clock::now();
  EXPECT_EQ(ReplyTo("Good morning"), (Response{0, 0})) << peer_.Output();
  const Duration took = std::chrono::steady_clock::now() - begun;
  const Result<Sound> received = ReadSound(Spoken("0001.wav"));
  ASSERT_TRUE(received);
  EXPECT_GT(received.value().Length(), Milliseconds(300));
  EXPECT_GE(took, received.value().Length());
}

TEST_F(AudioManagerProcess, SpeaksInEveryStateAndFallsSilentAtTearDown) {
  Start("output = \"silent\"\n" + kPhrases);
  for (const BuiltInState state :
       {kSelfCheck, kActive, kDeActive, kProtected, kOta, kError, kLowPower}) {
    ExpectDone(state);
  }
  EXPECT_EQ(ReplyTo("One"), (Response{0, 0}));
  Answer answer;
  Say(kLongText, answer);
  ASSERT_TRUE(AwaitWords(kLongText.substr(0, 20)));
  peer_.Send("TearDown");
  EXPECT_EQ(Await(answer), (Response{1, 5022}));
  ASSERT_TRUE(peer_.AwaitReply());
  EXPECT_EQ(peer_.AwaitExit(), 0) << peer_.Output();
}

TEST_F(AudioManagerProcess, SwitchesVoiceControlOffForAnUpgrade) {
  Start("output = \"silent\"\n" + kPhrases);
  ExpectDone("OTA");
  EXPECT_EQ(Call<msg::Trigger>("audio_action_get", {}), (msg::Trigger::Response{false, "off"}));
}

TEST_F(AudioManagerProcess, IsInterruptedByATopic) {
  Start("output = \"silent\"\n" + kPhrases);
  Answer answer;
  Say(kLongText, answer);
  ASSERT_TRUE(peer_.Until([this] { return sounds_; }));
  ASSERT_TRUE(play_->Publish({"test", msg::AudioPlay::kReady}));
  EXPECT_EQ(Await(answer), (Response{1, 5021}));
  EXPECT_TRUE(AwaitOutput("plays \"Good day. I am awake.\" for \"test\"")) << peer_.Output();
  EXPECT_TRUE(peer_.Until([this] { return !sounds_; })) << "and the phrase comes to its end";
}

TEST_F(AudioManagerProcess, PlaysTheCuesOfTheWedding) {
  const std::string config = SourceDir() + "/config/audio/";
  Start("output = \"silent\"\nlanguage = \"zh\"\n" + kPhrases +
        "[[cues]]\ntopic = \"/wedding/audio/play\"\nfile = \"" + config + "wedding_cues.toml\"\n");
  const auto cues = Publisher<msg::String>("wedding/audio/play");
  ASSERT_TRUE(peer_.Until([&] { return cues->MatchedReaders() > 0; }));
  ASSERT_TRUE(cues->Publish({"hiccup"}));
  ASSERT_TRUE(cues->Publish({"greeting"}));
  ASSERT_TRUE(peer_.Until([this] { return sounds_; }));
  EXPECT_TRUE(peer_.Until([this] { return !sounds_; })) << "it comes to its end";
  EXPECT_THAT(peer_.Output(), HasSubstr("audio: /wedding/audio/play has no cue \"hiccup\""));
  EXPECT_THAT(peer_.Output(), HasSubstr("plays \"欢迎来到婚礼现场！\" for \"greeting\""));
}

TEST_F(AudioManagerProcess, UsesTheWorldsClockAndAnswersAfterTenSecondsOfIt) {
  StartInAWorld("output = \"silent\"\n" + kPhrases);
  world_step_ = Milliseconds(10);
  EXPECT_EQ(ReplyTo("One"), (Response{0, 0})) << "as the world's time advances";
  world_step_ = Duration::zero();
  std::string text;
  for (int i = 0; i < 150; ++i) text += "word ";
  Answer answer;
  Say(text, answer);
  ASSERT_TRUE(AwaitWords("word word"));
  world_time_ += Milliseconds(9'900);
  EXPECT_EQ(ReplyTo(""), (Response{1, 5024}));
  EXPECT_FALSE(answer);
  world_time_ += Milliseconds(200);
  EXPECT_EQ(Await(answer), (Response{1, 5007}));
}

TEST_F(AudioManagerProcess, RefusesInvalidRequestsEachWithItsCode) {
  Start("output = \"silent\"\n" + kPhrases);
  EXPECT_EQ(ReplyTo(""), (Response{1, 5024}));
  EXPECT_EQ(ReplyTo(std::string(10'240, 'x')), (Response{1, 5025}));
  EXPECT_EQ(ReplyTo("a\xFF"), (Response{1, 5026}));
  Answer unknown;
  RequestText({"test", false, {"test", 4711}, ""}, unknown);
  EXPECT_EQ(Await(unknown), (Response{1, 5023}));
  EXPECT_THAT(peer_.Output(), HasSubstr("refused for \"test\": unknown phrase 4711"));
}

TEST_F(AudioManagerProcess, ContinuesWithoutItsOutputAndLogsItOnce) {
  Start(kWav);
  EXPECT_EQ(ReplyTo("One"), (Response{0, 0}));
  std::filesystem::remove_all(peer_.folder() / "spoken");
  std::ofstream(peer_.folder() / "spoken") << "in the way";
  EXPECT_EQ(ReplyTo("Two"), (Response{1, 5012}));
  EXPECT_EQ(ReplyTo("Three"), (Response{1, 5012}));
  const std::string log = peer_.Output();
  EXPECT_EQ(log.find("is not played"), log.rfind("is not played")) << log;
  EXPECT_EQ(peer_.Switch("SelfCheck").value().code, 5109);
  std::filesystem::remove(peer_.folder() / "spoken");
  EXPECT_EQ(ReplyTo("Four"), (Response{0, 0}));
  EXPECT_EQ(peer_.Switch("SelfCheck").value().code, 0);
  EXPECT_THAT(peer_.Output(), HasSubstr("the sound device is available again"));
}

TEST_F(AudioManagerProcess, FailsItsSelfCheckWhereAVoiceIsMissing) {
  Start("output = \"silent\"\n" + kPhrases + "[voice]\nchinese = \"unknown\"\n");
  EXPECT_EQ(Failure("SelfCheck"), "5009 espeak-ng: there is no voice \"unknown\"");
  EXPECT_EQ(ReplyTo("早上好"), (Response{1, 5027}));
  EXPECT_EQ(ReplyTo("One"), (Response{0, 0}));
}

TEST_F(AudioManagerProcess, ReportsAnInvalidFileAndExitsWithTwo) {
  ExpectRefused("output = \"radio\"\n" + kPhrases, "audio.toml:1:10: error: output");
}

// Its errors are in its output.
testing::Ended RunTool(const std::string& arguments) {
  return testing::RunToEnd({"sh", "-c", BinDir() + "/musher-audio " + arguments + " 2>&1"});
}

TEST_F(AudioManagerProcess, IsControlledByTheTool) {
  Start(kWav);
  const testing::Ended loud = RunTool("volume 20");
  EXPECT_EQ(loud.exit, 0) << loud.out;
  EXPECT_EQ(loud.out, "volume 20 %\n");
  EXPECT_THAT(RunTool("--json volume").out, HasSubstr("\"volume\": 20"));
  const testing::Ended spoken = RunTool("say One");
  EXPECT_EQ(spoken.exit, 0);
  EXPECT_EQ(spoken.out, "played to the end\n");
  const testing::Ended played = RunTool("play 1055 --json");
  EXPECT_EQ(played.exit, 0);
  EXPECT_THAT(played.out, HasSubstr("\"status\": 0"));
  const testing::Ended unknown = RunTool("play 4711");
  EXPECT_EQ(unknown.exit, 1);
  EXPECT_EQ(unknown.out, "musher-audio: unknown phrase number (5023)\n");
  EXPECT_EQ(RunTool("say '早上好' --now").exit, 0);
  ASSERT_TRUE(peer_.Until([this] { return sounds_; }));
  EXPECT_EQ(RunTool("stop").out, "silent\n");
  EXPECT_TRUE(peer_.Until([this] { return !sounds_; }));
}

// The tool published once any reader was matched: with a recorder of the topic the audio module
// missed it.
TEST_F(AudioManagerProcess, ARequestOfTheToolIsForTheModuleAndNotForAnotherReader) {
  int recorded = 0;
  const auto recorder = transport::MakeSubscription<msg::AudioPlayExtend>(
      peer_.node(), "speech_play_extend",
      [&](const msg::AudioPlayExtend&, const transport::SampleInfo&) { ++recorded; });
  ASSERT_TRUE(recorder);
  const testing::Ended ran = RunTool("say One --now");
  EXPECT_EQ(ran.exit, 1);
  EXPECT_THAT(ran.out, HasSubstr("no audio module"));
  peer_.node().loop().RunUntil([] { return false; }, peer_.node().loop().Now());
  EXPECT_EQ(recorded, 0);
}

TEST(AudioTool, ReportsACommandLineError) {
  for (const std::string wrong :
       {"", "sing", "say", "play", "play hello", "play 70000", "volume 101", "volume -1",
        "volume loud", "stop now", "say One --clock sun"}) {
    const testing::Ended ran = RunTool(wrong);
    EXPECT_EQ(ran.exit, 2) << wrong;
    EXPECT_THAT(ran.out, HasSubstr("musher-audio: ")) << wrong;
  }
}

TEST(AudioTool, ListsThePhrases) {
  const testing::Ended text = RunTool("phrases");
  EXPECT_EQ(text.exit, 0);
  EXPECT_THAT(text.out, HasSubstr("1000 to 1100  The battery is at {number} percent."));
  const testing::Ended json = RunTool("phrases --json");
  EXPECT_THAT(json.out, HasSubstr("\"zh\": \"准备好了。\""));
  const testing::Ended absent = RunTool("phrases --phrases /absent.toml");
  EXPECT_EQ(absent.exit, 2);
  EXPECT_THAT(absent.out, HasSubstr("/absent.toml: error: the file cannot be read"));
}

TEST(AudioTool, ReportsThatThereIsNoAudioModule) {
  for (const std::string command : {"say One", "say One --now"}) {
    const testing::Ended ran = RunTool("--namespace nowhere_at_all " + command);
    EXPECT_EQ(ran.exit, 1) << command;
    EXPECT_THAT(ran.out, HasSubstr("no audio module in namespace 'nowhere_at_all'"));
  }
  EXPECT_THAT(RunTool("--clock topic --namespace nowhere_at_all stop").out,
              HasSubstr("no publisher of /clock"));
}

}  // namespace musher::audio::audio_process_test
