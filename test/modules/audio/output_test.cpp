// Where sound goes: files that are read back, a device of ALSA that is a file, and silence.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "musher/messages/stamp.hpp"
#include "musher/modules/audio/audio_code.hpp"
#include "musher/modules/audio/output.hpp"
#include "musher/modules/audio/sound_file.hpp"
#include "musher/modules/audio/sound_maker.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::audio::output_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Sound Tone(Duration length) {
  Sound sound;
  const auto samples = static_cast<std::size_t>(ToMilliseconds(length) * sound.rate_hz / 1000);
  for (std::size_t i = 0; i < samples; ++i) {
    sound.samples.push_back(static_cast<std::int16_t>(i % 100 < 50 ? 10'000 : -10'000));
  }
  return sound;
}

int Loudest(const Sound& sound) {
  int loudest = 0;
  for (const std::int16_t sample : sound.samples) loudest = std::max(loudest, std::abs(sample));
  return loudest;
}

// A clock that is advanced by the test.
class HandClock : public transport::Clock {
 public:
  Time Now() const override { return now_; }
  msg::Stamp Stamp() const override { return msg::ToStamp(now_.time_since_epoch()); }
  transport::LoopHandlePtr At(Time when, std::function<void()> callback) override {
    return timers_.Add(when, Duration::zero(), std::move(callback));
  }
  transport::LoopHandlePtr Every(Duration period, std::function<void()> callback) override {
    return timers_.Add(now_ + period, period, std::move(callback));
  }
  void Pass(Duration time) {
    now_ += time;
    while (timers_.RunNext(now_)) {
    }
  }

 private:
  Time now_{};
  transport::TimerQueue timers_;
};

class Outputs : public ::testing::Test {
 protected:
  void Make(const OutputConfig& config) {
    output_ = MakeOutput(config, loop_, clock_,
                         [this](const std::string& line) { log_.push_back(line); });
  }
  void Play(Duration length) {
    ended_.reset();
    output_->Play(std::make_shared<const Sound>(Tone(length)),
                  [this](const Result<>& result) { ended_ = result; });
  }
  // Waits for the end of what plays.
  Result<> Ended() {
    loop_.RunUntil([this] { return ended_.has_value(); }, loop_.Now() + std::chrono::seconds(120));
    return ended_.value_or(Error{-1, "it does not end"});
  }
  Sound File(const std::string& name) {
    // A file is written beside the loop; the destructor waits until all is written.
    output_.reset();
    const Result<Sound> sound = ReadSound(folder_ / name);
    EXPECT_TRUE(sound) << (sound ? "" : sound.error().message);
    return sound ? sound.value() : Sound{};
  }

  const TempFolder folder_;
  transport::LinuxEventLoop loop_;
  HandClock clock_;
  std::vector<std::string> log_;
  std::optional<Result<>> ended_;
  std::unique_ptr<Output> output_;
};

class WavFiles : public Outputs {
 protected:
  WavFiles() { Make({OutputKind::kWav, "", folder_.path()}); }
};

TEST_F(WavFiles, HaveTheSoundInItsLengthAndEndWithTheClock) {
  Play(Milliseconds(300));
  clock_.Pass(Milliseconds(299));
  EXPECT_FALSE(loop_.RunUntil([this] { return ended_.has_value(); }, loop_.Now()));
  clock_.Pass(Milliseconds(1));
  EXPECT_TRUE(Ended());
  EXPECT_EQ(File("0001.wav").samples, Tone(Milliseconds(300)).samples);
}

TEST_F(WavFiles, AreAsLoudAsTheVolume) {
  output_->SetVolume(50);
  Play(Milliseconds(100));
  clock_.Pass(Milliseconds(100));
  EXPECT_TRUE(Ended());
  EXPECT_EQ(Loudest(File("0001.wav")), 5'000);
}

TEST_F(WavFiles, BecomeQuieterInTheMiddleOfASound) {
  Play(Milliseconds(200));
  clock_.Pass(Milliseconds(100));
  output_->SetVolume(0);
  clock_.Pass(Milliseconds(100));
  EXPECT_TRUE(Ended());
  Sound received = File("0001.wav");
  ASSERT_EQ(received.samples.size(), 4'410U);
  EXPECT_EQ(std::abs(received.samples[2'204]), 10'000);
  EXPECT_EQ(received.samples[2'205], 0);
}

TEST_F(WavFiles, EndWhereTheSoundWasStopped) {
  Play(Milliseconds(1'000));
  clock_.Pass(Milliseconds(200));
  output_->Stop();
  clock_.Pass(Milliseconds(2'000));
  EXPECT_EQ(File("0001.wav").samples.size(), 4'410U);
  EXPECT_FALSE(ended_);
}

TEST_F(WavFiles, ContinueWithTheirNumbersAfterARestart) {
  std::ofstream(folder_ / "0041.wav") << "old";
  std::ofstream(folder_ / "notes.txt") << "99";
  Make({OutputKind::kWav, "", folder_.path()});
  Play(Milliseconds(10));
  clock_.Pass(Milliseconds(10));
  EXPECT_TRUE(Ended());
  EXPECT_EQ(File("0042.wav").samples.size(), 220U);
}

TEST_F(WavFiles, ThatCannotBeWrittenAreReportedWithTheCodeOfADevice) {
  std::ofstream(folder_ / "taken") << "a file";
  Make({OutputKind::kWav, "", folder_ / "taken"});
  EXPECT_EQ(output_->Check().error().code, 5109);
  Play(Milliseconds(10));
  clock_.Pass(Milliseconds(10));
  EXPECT_EQ(Ended().error().code, 5012);
}

TEST_F(Outputs, InSilenceTakeAsLongAsTheSound) {
  Make({OutputKind::kSilent, "", ""});
  Play(Milliseconds(300));
  clock_.Pass(Milliseconds(299));
  EXPECT_FALSE(ended_);
  clock_.Pass(Milliseconds(1));
  EXPECT_TRUE(ended_);
  Play(Milliseconds(300));
  output_->Stop();
  clock_.Pass(Milliseconds(300));
  EXPECT_FALSE(ended_);
}

TEST_F(Outputs, AreSilentWithOneLineWhereThereIsNoDevice) {
  Make({OutputKind::kAuto, "no_such_device", ""});
  EXPECT_THAT(log_, ElementsAre(HasSubstr("no sound device, the output is silent: sound device "
                                          "no_such_device: ")));
  EXPECT_TRUE(output_->Check());
  Play(Milliseconds(10));
  clock_.Pass(Milliseconds(10));
  EXPECT_TRUE(Ended());
}

TEST_F(Outputs, OfAMissingDeviceFailWithItsCode) {
  Make({OutputKind::kAlsa, "no_such_device", ""});
  EXPECT_THAT(log_, ElementsAre(HasSubstr("no sound yet: ")));
  EXPECT_EQ(output_->Check().error().code, kBoardFailed);
  Play(Milliseconds(10));
  EXPECT_EQ(Ended().error().code, 5012);
  EXPECT_THAT(Ended().error().message, HasSubstr("no_such_device"));
}

// ALSA's own device that writes what is played into a file.
class AlsaFile : public Outputs {
 protected:
  AlsaFile() { Make({OutputKind::kAlsa, "file:'" + file_ + "',raw", ""}); }

  std::vector<std::int16_t> PlayedSamples() const {
    std::ifstream stream(file_, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    std::vector<std::int16_t> samples(bytes.size() / sizeof(std::int16_t));
    std::copy_n(bytes.begin(), samples.size() * sizeof(std::int16_t),
                reinterpret_cast<char*>(samples.data()));
    return samples;
  }

  const std::string file_ = folder_ / "played";
};

TEST_F(AlsaFile, HasTheWholeSoundAtItsVolume) {
  ASSERT_TRUE(output_->Check());
  output_->SetVolume(25);
  Play(Milliseconds(500));
  EXPECT_TRUE(Ended());
  std::vector<std::int16_t> expected = Tone(Milliseconds(500)).samples;
  for (std::int16_t& sample : expected) sample = Scaled(sample, 25);
  EXPECT_EQ(PlayedSamples(), expected);
}

TEST_F(AlsaFile, IsAvailableAgainAfterItWasLost) {
  constexpr Duration kLong = Milliseconds(500);  // more than the device's buffer
  Play(kLong);
  EXPECT_TRUE(Ended());
  std::filesystem::remove_all(folder_.path());
  Play(kLong);
  ASSERT_FALSE(Ended());
  EXPECT_EQ(Ended().error().code, 5012);
  std::filesystem::create_directory(folder_.path());
  Play(kLong);
  EXPECT_TRUE(Ended());
}

TEST_F(AlsaFile, ReportsNoEndOfAStoppedSound) {
  Play(std::chrono::seconds(5));
  output_->Stop();
  Play(Milliseconds(20));
  EXPECT_TRUE(Ended());
}

class RealVoice : public ::testing::Test {
 protected:
  Result<Sound> Make(const Utterance& what) {
    std::optional<Result<Sound>> made;
    maker_.Make(what, [&made](Result<Sound> sound) { made = std::move(sound); });
    loop_.RunUntil([&] { return made.has_value(); }, loop_.Now() + std::chrono::seconds(120));
    return made.value_or(Error{-1, "never made"});
  }

  const TempFolder folder_;
  transport::LinuxEventLoop loop_;
  VoiceMaker maker_{loop_, VoiceConfig{}};
};

TEST_F(RealVoice, SpeaksBothLanguages) {
  EXPECT_TRUE(maker_.Check());
  const auto english = Make({"Hello, I am ready.", Language::kEnglish, {}});
  const auto chinese = Make({"你好，我准备好了。", Language::kChinese, {}});
  for (const auto* sound : {&english, &chinese}) {
    ASSERT_TRUE(*sound);
    EXPECT_GT(sound->value().Length(), Milliseconds(700));
    EXPECT_LT(sound->value().Length(), Milliseconds(5'000));
    EXPECT_GT(Loudest(sound->value()), 5'000);
  }
}

TEST_F(RealVoice, TakesLongerForMoreText) {
  const auto shorter = Make({"One.", Language::kEnglish, {}});
  const auto longer = Make({"One two three four five six.", Language::kEnglish, {}});
  EXPECT_GT(longer.value().Length(), shorter.value().Length() * 2);
}

TEST_F(RealVoice, DropsCancelledSounds) {
  std::string long_text;
  for (int i = 0; i < 1'000; ++i) long_text += "word ";
  maker_.Make({long_text, Language::kEnglish, {}},
              [](const Result<Sound>&) { ADD_FAILURE() << "cancelled"; });
  EXPECT_TRUE(Make({"One.", Language::kEnglish, {}}));
  maker_.Make({long_text, Language::kEnglish, {}},
              [](const Result<Sound>&) { ADD_FAILURE() << "cancelled"; });
  maker_.Cancel();
  EXPECT_TRUE(maker_.Check());
}

TEST_F(RealVoice, ReportsAMissingVoice) {
  VoiceConfig config;
  config.english = "klingon_high_court";
  VoiceMaker maker(loop_, config);
  EXPECT_EQ(maker.Check().error().code, 5027);
  EXPECT_THAT(maker.Check().error().message, HasSubstr("no voice \"klingon_high_court\""));
}

TEST_F(RealVoice, PlaysRecordingsOfSeveralChannelsAsOne) {
  const std::string file = folder_ / "r.wav";
  ASSERT_TRUE(WriteWav(file, {16'000, {100, 200, -300}}));
  const auto sound = Make({"", Language::kEnglish, file});
  ASSERT_TRUE(sound);
  EXPECT_EQ(sound.value().rate_hz, 16'000);
  EXPECT_THAT(sound.value().samples, ElementsAre(100, 200, -300));
}

TEST_F(RealVoice, ReportsARecordingThatIsMissingMeanwhile) {
  EXPECT_EQ(Make({"", Language::kEnglish, folder_ / "gone.wav"}).error().code, 5028);
}

}  // namespace musher::audio::output_test
