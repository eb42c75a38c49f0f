// Properties of the manager's voice for all events in any order.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <set>

#include "musher/cyberdog/voice.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::cyberdog::voice_property_test {

VoicePolicy AnyVoice() {
  VoicePolicy voice;
  voice.quiet_asleep = *rc::gen::arbitrary<bool>();
  voice.say.clear();
  for (const auto& [name, occasion] : kOccasions) {
    if (*rc::gen::weightedElement<bool>({{1, false}, {4, true}})) voice.say.push_back(occasion);
  }
  return voice;
}

MachineConfig ConfigWith(const VoicePolicy& voice) {
  MachineConfig config = testing::MachineOf(2);
  config.policy.emplace();
  config.policy->manager = true;
  config.policy->battery.emplace();
  CompletePolicy(voice, *config.policy);
  return config;
}

MachineSummary AnyGlimpse() {
  MachineSummary machine;
  machine.phase = *rc::gen::weightedElement<Phase>(
      {{1, Phase::kStarting}, {8, Phase::kRunning}, {1, Phase::kFailed}, {1, Phase::kStopping}});
  machine.state = *rc::gen::element<State>(State(kActive), State(kProtected), State(kLowPower));
  machine.loaded = *rc::gen::arbitrary<bool>();
  machine.battery = *rc::gen::inRange(0, 101);
  machine.level = *rc::gen::element(BatteryLevel::kFree, BatteryLevel::kProtected,
                                    BatteryLevel::kLowPower, BatteryLevel::kEmpty);
  machine.empty = machine.level == BatteryLevel::kEmpty && *rc::gen::arbitrary<bool>();
  machine.charging = *rc::gen::arbitrary<bool>();
  if (*rc::gen::arbitrary<bool>()) machine.faults = {{"a", {2109, "silent"}}};
  return machine;
}

VoiceEvent Anything(const VoiceState& voice) {
  switch (*rc::gen::inRange(0, 8)) {
    case 0:
    case 1:
      return voice_event::MachineSeen{AnyGlimpse()};
    case 2: {
      const auto kind = *rc::gen::element<std::string>("policy", "switch", "actuator");
      const CommandNumber number(*rc::gen::inRange<std::uint64_t>(0, 3));
      const auto code = *rc::gen::element(0, 103, 111, 2109, 3001);
      return voice_event::Recorded{{kind, std::nullopt, number, code, "why"}};
    }
    case 3:
      return voice_event::DoubleTapped{};
    case 4:
      return voice_event::AppConnected{};
    case 5:
      return voice_event::PlayerMatched{*rc::gen::weightedElement<bool>({{1, false}, {4, true}})};
    case 6:
      return voice_event::PlayReported{*rc::gen::arbitrary<bool>()};
    default:
      return voice_event::PlayEnded{*rc::gen::element(voice.number, voice.number - 1)};
  }
}

// Advances the time: an event arrives after up to three seconds, deadlines pass in between.
class Life {
 public:
  void Live(int steps) {
    for (int i = 0; i < steps; ++i) {
      const Time next = now_ + Milliseconds(*rc::gen::inRange(0, 3000));
      for (auto at = NextVoiceDeadline(voice_); at && *at <= next; at = NextVoiceDeadline(voice_)) {
        RC_ASSERT(*at >= now_ || !voice_.playing);
        now_ = std::max(now_, *at);
        Step(voice_event::TimePassed{});
      }
      now_ = next;
      Step(Anything(voice_));
    }
  }
  void Step(const VoiceEvent& what) {
    const VoiceState before = voice_;
    for (const VoiceAction& action : Speak(config_, voice_, what, now_))
      Check(action, before, what);
    RC_ASSERT(voice_.waiting.size() <= kMostWaiting);
    const auto next = NextVoiceDeadline(voice_);
    RC_ASSERT(!next || *next > now_);  // the loop never spins
    const bool owes = voice_.playing || !voice_.waiting.empty();
    RC_ASSERT(owes == next.has_value());  // whatever is owed comes to its end by itself
  }

 private:
  void Check(const VoiceAction& action, const VoiceState& before, const VoiceEvent& what) {
    if (std::holds_alternative<voice_action::StandUp>(action)) RC_ASSERT(++stood_up_ == 1);
    const auto* play = std::get_if<voice_action::Play>(&action);
    if (play == nullptr) return;
    RC_ASSERT(voice_.player);
    const auto* ended = std::get_if<voice_event::PlayEnded>(&what);
    const bool one_at_a_time = !before.playing || now_ >= before.playing->until ||
                               (ended != nullptr && ended->number == before.number) ||
                               std::holds_alternative<voice_event::PlayerMatched>(what);
    RC_ASSERT(one_at_a_time);
    const std::uint16_t id = play->utterance.id;
    const bool once = id == 9000 || id == 60 || id == 61 || id == 2002 || id == 5300;
    const bool both_failed_and_up = id == 61 && voice_.failure_announced && voice_.start_announced;
    if (once) RC_ASSERT(once_.insert(id).second || both_failed_and_up);
  }

  MachineConfig config_ = ConfigWith(AnyVoice());
  VoiceState voice_;
  Time now_{std::chrono::seconds(100)};
  std::set<std::uint16_t> once_;
  int stood_up_ = 0;
};

RC_GTEST_PROP(VoiceProperty, OneAtATimeNothingTwiceAndNothingForEver, ()) {
  Life().Live(*rc::gen::inRange(10, 120));
}

// Nothing that is queued while it sleeps, but the answer to a touch.
RC_GTEST_PROP(VoiceProperty, AQuietSleeperIsQuiet, ()) {
  VoicePolicy quiet = AnyVoice();
  quiet.quiet_asleep = true;
  const MachineConfig config = ConfigWith(quiet);
  VoiceState voice;
  Time now{std::chrono::seconds(100)};
  const auto feed = [&](const VoiceEvent& what) { return Speak(config, voice, what, now); };
  MachineSummary machine;
  machine.phase = Phase::kRunning;
  machine.state = kLowPower;
  machine.adopted = true;
  machine.battery = 50;
  feed(voice_event::MachineSeen{machine});
  for (int i = 0; i < 50; ++i) {
    VoiceEvent what = Anything(voice);
    if (auto* seen = std::get_if<voice_event::MachineSeen>(&what)) {
      seen->machine.phase = Phase::kRunning;
      seen->machine.state = kLowPower;
    }
    now += Milliseconds(*rc::gen::inRange(0, 3000));
    for (const VoiceAction& action : feed(what)) {
      const auto* play = std::get_if<voice_action::Play>(&action);
      if (play == nullptr) continue;
      const std::uint16_t id = play->utterance.id;
      RC_ASSERT((id >= 1000 && id <= 1100) || !play->utterance.text.empty());
      RC_ASSERT(play->utterance.text.find("why") == std::string::npos);
    }
  }
}

}  // namespace musher::cyberdog::voice_property_test
