// The manager's voice on the wire: a simulated robot with an audio module that records its play
// requests.

#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/test/cyberdog/managed_robot.hpp"
#include "musher/transport/clock.hpp"

namespace musher::testing::speaker_test {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ASpeakingRobot : public ManagedRobot {
 protected:
  explicit ASpeakingRobot(MachineConfig config = WithAudio(), simulation::Script script = {})
      : ManagedRobot(std::move(config), std::move(script)),
        tap_(PublishFunction<msg::TouchStatus>("touch_status")),
        app_connects_(PublishFunction<msg::Bool>("app_connection_state")),
        wake_word_(PublishFunction<msg::Bool>("dog_wakeup")) {}

  static MachineConfig WithAudio() {
    MachineConfig config = ManagedMachine();
    config.actuators[1].name = "audio";
    config.actuators[1].command = {"run", "audio"};
    return config;
  }

  using Reply = transport::Server<msg::AudioTextPlay>::Reply;
  // Answers after a second; a mute one never.
  void PlugAudioIn(bool mute = false) {
    audio_ = transport::MakeServer<msg::AudioTextPlay>(
                 *app_, "dog/speech_text_play",
                 [this, mute](const msg::AudioTextPlay::Request& request, const Reply& reply) {
                   EXPECT_EQ(request.module_name, "cyberdog_manager");
                   EXPECT_EQ(request.is_online, !request.text.empty());
                   said_.push_back(request.is_online ? request.text
                                                     : std::to_string(request.speech.play_id));
                   if (mute) return;
                   ends_ = app_->loop().At(app_->loop().Now() + seconds(1), [reply] {
                     reply({msg::AudioTextPlay::kFinished, 0});
                   });
                 })
                 .value();
  }
  // A battery that publishes this once a second.
  void SetBattery(int percent) {
    robot_.SetBattery(percent, false);
    robot_.RunFor(Milliseconds(1500));
  }
  void BringUp() {
    ManagedRobot::BringUp();
    SetBattery(80);
  }
  void DoubleTap() { tap_({{}, msg::TouchStatus::kDoubleTouch, 0}); }
  std::vector<std::string> Said(Duration within = seconds(30)) {
    robot_.RunFor(within);
    return std::exchange(said_, {});
  }

  std::function<void(const msg::TouchStatus&)> tap_;
  std::function<void(const msg::Bool&)> app_connects_;
  std::function<void(const msg::Bool&)> wake_word_;
  std::vector<std::string> said_;
  transport::LoopHandlePtr ends_;
  std::unique_ptr<transport::Server<msg::AudioTextPlay>> audio_;
};

TEST_F(ASpeakingRobot, AnnouncesThatItIsReady) {
  PlugAudioIn();
  BringUp();
  EXPECT_THAT(Said(), ElementsAre("9000", "60"));
}

TEST_F(ASpeakingRobot, AnnouncesItsChargeOnADoubleTap) {
  PlugAudioIn();
  BringUp();
  SetBattery(83);
  Said();
  DoubleTap();
  EXPECT_THAT(Said(), ElementsAre("1083"));
}

TEST_F(ASpeakingRobot, AnnouncesTheLevelsOfItsBatteryAndItsTearDown) {
  PlugAudioIn();
  BringUp();
  Said();
  // In steps that a battery can make: a larger one is announced as a fault of its sensor.
  for (const int percent : {72, 64, 56, 48, 40, 30, 20, 12, 5}) {
    SetBattery(percent);
    robot_.RunFor(seconds(5));
  }
  EXPECT_THAT(Said(), ElementsAre("10030", "10020", "10005"));
  SetBattery(0);
  EXPECT_THAT(Said(seconds(0)), IsEmpty()) << "one sample announces no end";
  EXPECT_THAT(Said(seconds(3)), ElementsAre("10000"));
  EXPECT_EQ(state(), kLowPower) << "the word is played before the voice is torn down";
  EXPECT_TRUE(robot_.RunUntil([&] { return state() == kTearDown; }, seconds(6)));
}

TEST_F(ASpeakingRobot, AnnouncesWhyAWakeWordIsRefused) {
  PlugAudioIn();
  BringUp();
  SetBattery(4);
  Said();
  ASSERT_EQ(state(), kLowPower);
  wake_word_({true});
  EXPECT_THAT(Said(), ElementsAre("wake-up refused: the battery is at 4 %: the machine is "
                                  "limited to LowPower until it is charged to 7 %"));
}

TEST_F(ASpeakingRobot, StandsUpForTheFirstApp) {
  PlugAudioIn();
  std::vector<std::pair<int, int>> motions;
  auto motion = transport::MakeServer<msg::MotionResultCmd>(
      *app_, "dog/motion_result_cmd",
      [&](const msg::MotionResultCmd::Request& request, const auto& reply) {
        motions.emplace_back(request.motion_id, request.cmd_source);
        reply({request.motion_id, true, 0});
      });
  BringUp();
  Said();
  app_connects_({false});
  app_connects_({true});
  app_connects_({true});
  EXPECT_THAT(Said(), ElementsAre("2002"));
  EXPECT_THAT(motions, ElementsAre(std::pair(111, 0)));
}

TEST_F(ASpeakingRobot, ContinuesWithAPlayerThatNeverReplies) {
  PlugAudioIn(true);
  BringUp();
  EXPECT_THAT(Said(seconds(3)), ElementsAre("9000"));
  EXPECT_THAT(Said(seconds(3)), ElementsAre("60"));
  Take("LowPower");
  EXPECT_EQ(state(), kLowPower);
}

TEST_F(ASpeakingRobot, RecordsOnceThatNoPlayerIsAvailable) {
  BringUp();
  robot_.RunFor(seconds(30));
  EXPECT_THAT(Records(), HasSubstr("no service speech_text_play"));
  DoubleTap();
  robot_.RunFor(seconds(30));
  EXPECT_EQ(Records(), "");
}

class ARobotWithoutAudio : public ASpeakingRobot {
 protected:
  ARobotWithoutAudio() : ASpeakingRobot(ManagedMachine()) {}
};

TEST_F(ARobotWithoutAudio, AnnouncesNothingAboutIt) {
  BringUp();
  Records();
  robot_.RunFor(seconds(30));
  EXPECT_EQ(Records(), "");
}

class ARobotWithALameLeg : public ASpeakingRobot {
 protected:
  ARobotWithALameLeg()
      : ASpeakingRobot(WithAudio(), [this](const std::string& name, const State& state) {
          simulation::Act act;
          if (lame_ && name == "a" && state == kActive) act.error = {3012, "a leg is lame"};
          return act;
        }) {}
  bool lame_ = false;
};

TEST_F(ARobotWithALameLeg, AnnouncesThatItsMotionDoesNotSwitch) {
  PlugAudioIn();
  BringUp();
  Take("LowPower");
  Said();
  lame_ = true;
  ASSERT_FALSE(robot_.Set("Active")->done());
  EXPECT_THAT(Said(), ElementsAre("31025"));
}

class AMutedRobot : public ASpeakingRobot {
 protected:
  AMutedRobot() : ASpeakingRobot(Muted()) {}
  static MachineConfig Muted() {
    MachineConfig config = WithAudio();
    cyberdog::VoicePolicy voice;
    voice.say.clear();
    cyberdog::CompletePolicy(voice, *config.policy);
    return config;
  }
};

TEST_F(AMutedRobot, AnnouncesNothing) {
  PlugAudioIn();
  BringUp();
  SetBattery(3);
  DoubleTap();
  EXPECT_THAT(Said(), IsEmpty());
}

// Its times are those of /clock: the pause between two taps, and how long the voice is waited for.
class ARobotInAWorld : public ASpeakingRobot {
 protected:
  ARobotInAWorld() : ASpeakingRobot(OnTopicClock()) {
    clock_ =
        transport::MakePublisher<msg::Clock>(*app_, transport::kClockTopic, transport::kClockQos)
            .value();
  }
  static MachineConfig OnTopicClock() {
    MachineConfig config = WithAudio();
    config.clock = ClockSource::kTopic;
    return config;
  }
  // The world shows `now`, once.
  void ShowTime(Duration now) {
    const auto whole = std::chrono::duration_cast<seconds>(now);
    ASSERT_TRUE(clock_
                    ->Publish({{static_cast<std::int32_t>(whole.count()),
                                static_cast<std::uint32_t>((now - whole).count())}})
                    .ok());
    robot_.RunFor(Milliseconds(200));
  }
  std::unique_ptr<transport::Publisher<msg::Clock>> clock_;
};

TEST_F(ARobotInAWorld, WaitsForItsVoiceByTheTimeOfTheWorld) {
  PlugAudioIn(true);
  robot_.StartController();
  Settle();
  ShowTime(seconds(100));
  ASSERT_TRUE(robot_.RunUntil([&] { return robot_.machine().phase == Phase::kRunning; }));
  EXPECT_THAT(Said(seconds(20)), ElementsAre("9000")) << "the world stands still";
  ShowTime(seconds(107));
  EXPECT_THAT(Said(seconds(1)), ElementsAre("60"));
}

TEST_F(ARobotInAWorld, ContinuesAlsoWhenTheWorldStandsStill) {
  PlugAudioIn(true);
  robot_.StartController();
  Settle();
  ShowTime(seconds(100));
  EXPECT_THAT(Said(seconds(70)), ElementsAre("9000", "60"));
}

}  // namespace musher::testing::speaker_test
