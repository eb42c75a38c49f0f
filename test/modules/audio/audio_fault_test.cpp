// The voice under injected faults: from TearDown on it is silent, and what it plays then ends; in
// all other states it speaks, also during an emergency stop, when a robot may announce why it
// stands.

#include "musher/modules/audio/audio_manager.hpp"
#include "musher/test/modules/audio/voice_on_a_network.hpp"
#include "musher/test/modules/module_fault_test.hpp"

namespace musher::audio::audio_fault_test {

// An application that speaks at all times.
class Application {
 public:
  explicit Application(transport::Node& desk)
      : play_(transport::MakePublisher<msg::AudioPlayExtend>(desk, "speech_play_extend").value()),
        sounds_(transport::MakeSubscription<msg::Bool>(
                    desk, "audio_notification_report",
                    [this](const msg::Bool& sounds, const auto&) { reports += sounds.data; })
                    .value()),
        ticker_(desk.loop().Every(Milliseconds(300), [this] {
          static_cast<void>(play_->Publish({"app", true, {}, "a sentence of three seconds..."}));
        })) {}

  int reports = 0;  // that there is sound

 private:
  std::unique_ptr<transport::Publisher<msg::AudioPlayExtend>> play_;
  std::unique_ptr<transport::Subscription> sounds_;
  transport::LoopHandlePtr ticker_;
};

TEST(TheAudioManager, IsSilentFromTearDownOnAndSpeaksInAllOtherStatesUnderInjectedFaults) {
  musher::testing::ModuleFaultTest<AudioManager, Application> test;
  test.make = [] {
    AudioConfig config;
    config.output.kind = OutputKind::kSilent;
    config.phrases = testing::ThePhrases();
    return std::make_unique<AudioManager>("audio", config, [](transport::EventLoop& loop) {
      return std::make_unique<testing::StandInMaker>(loop);
    });
  };
  const auto speaks = [&test] {
    test.Pass(Milliseconds(200));  // discovery, and what is under way
    test.peers->reports = 0;
    test.Pass(Milliseconds(700));
    return test.peers->reports > 0;
  };
  int silent = 0;
  int in_a_stop = 0;
  test.always = [&](const AudioManager&, const ActuatorReport& report) {
    const bool ends = report.state == kTearDown;
    if (ends) ++silent;
    EXPECT_EQ(speaks(), !ends) << report.state;
    if (!ends && report.emergency_stop != 0) ++in_a_stop;
  };
  test.Run();
  EXPECT_GT(silent, 50) << "or nothing has been tried";
  EXPECT_GT(in_a_stop, 20) << "or nothing has been tried";
}

}  // namespace musher::audio::audio_fault_test
