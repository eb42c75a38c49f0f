#pragma once
// The audio module on the simulated network, in virtual time, with the clients of a desk. A fake
// makes the sound, 100 ms for each character, so that no thread is needed.

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/audio/audio_shell.hpp"
#include "musher/test/modules/audio/harness.hpp"
#include "musher/test/modules/module_on_network.hpp"

namespace musher::audio::testing {

class StandInMaker : public SoundMaker {
 public:
  explicit StandInMaker(transport::EventLoop& loop) : loop_(loop) {}

  void Make(const Utterance& what, Done done) override {
    Sound sound;
    sound.samples.resize(what.text.size() * static_cast<std::size_t>(sound.rate_hz) / 10);
    timer_ = loop_.At(loop_.Now() + Milliseconds(5), [sound, done = std::move(done)] {
      const Done then = done;  // the timer may be dropped in there
      then(sound);
    });
  }
  void Cancel() override { timer_.reset(); }
  Result<> Check() override { return Ok(); }

 private:
  transport::EventLoop& loop_;
  transport::LoopHandlePtr timer_;
};

class VoiceOnANetwork : public test::ModuleOnNetwork {
 protected:
  VoiceOnANetwork() {
    config_.phrases = ThePhrases();
    config_.cue_topics = TheCueTopics();
    shell_ = AudioShell::Make({*robot_, *clock_, "dog1",
                               [this](const std::string& line) { log_ += line + "\n"; }},
                              config_, maker_, output_)
                 .value();
    report_ = transport::MakeSubscription<msg::Bool>(
                  *desk_, "dog1/audio_notification_report",
                  [this](const msg::Bool& report, const auto&) { reports_.push_back(report.data); })
                  .value();
    play_ = Publisher<msg::AudioPlay>("dog1/speech_play");
    extended_ = Publisher<msg::AudioPlayExtend>("dog1/speech_play_extend");
    text_ = transport::MakeClient<msg::AudioTextPlay>(*desk_, "dog1/speech_text_play").value();
    Run(Milliseconds(500));  // discovery
  }

  using Answer = std::optional<msg::AudioTextPlay::Response>;

  void RequestText(const msg::AudioTextPlay::Request& request, Answer& answer) {
    text_->Call(request, std::chrono::seconds(60), [&answer](const auto& reply) {
      ASSERT_TRUE(reply) << reply.error().message;
      answer = reply.value();
    });
  }
  void Say(const std::string& text, Answer& answer) {
    RequestText({"app", true, {}, text}, answer);
  }

  template <msg::Service S>
  typename S::Response Call(const std::string& service, const typename S::Request& request) {
    return ModuleOnNetwork::Call<S>("dog1/" + service, request);
  }

  AudioConfig config_;
  StandInMaker maker_{robot_->loop()};
  SilentOutput output_{*clock_};
  std::string log_;
  std::vector<bool> reports_;
  std::unique_ptr<AudioShell> shell_;
  std::unique_ptr<transport::Subscription> report_;
  std::unique_ptr<transport::Publisher<msg::AudioPlay>> play_;
  std::unique_ptr<transport::Publisher<msg::AudioPlayExtend>> extended_;
  std::unique_ptr<transport::Client<msg::AudioTextPlay>> text_;
};

}  // namespace musher::audio::testing
