#pragma once
// A manager's voice, its events and a player, in plain values.

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "musher/cyberdog/voice.hpp"
#include "musher/cyberdog/voice_policy.hpp"
#include "musher/lifecycle/policy/policy.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::cyberdog {

inline MachineConfig ManagedConfig(int stages = 2) {
  MachineConfig config = testing::MachineOf(2);
  config.actuators.back().stage = stages;
  config.policy.emplace();
  config.policy->manager = true;
  config.policy->battery.emplace();
  return config;
}

// A manager whose player replies after a second, unless a test disables that.
class Voices : public ::testing::Test {
 protected:
  Voices() {
    machine_.state = kActive;
    Feed(voice_event::PlayerMatched{true});
  }

  void Feed(const VoiceEvent& event) {
    for (const VoiceAction& action : Speak(config_, voice_, event, now_)) {
      if (const auto* play = std::get_if<voice_action::Play>(&action)) {
        const Utterance& u = play->utterance;
        said_.push_back(u.text.empty() ? std::to_string(u.id) : u.text);
        if (answers_) answer_at_ = now_ + std::chrono::seconds(1);
      } else if (std::holds_alternative<voice_action::StandUp>(action)) {
        said_.emplace_back("stand up");
      } else {
        said_.emplace_back("(dropped)");
      }
    }
  }
  void Show() { Feed(voice_event::MachineSeen{machine_}); }
  void Wait(Duration duration) {
    const Time end = now_ + duration;
    while (true) {
      const auto next = NextVoiceDeadline(voice_);
      const Time at = std::min(next.value_or(end), answer_at_.value_or(end));
      if (at > end || (at == end && at == now_)) break;
      now_ = std::max(now_, at);
      if (answer_at_ && *answer_at_ <= now_) {
        answer_at_.reset();
        Feed(voice_event::PlayEnded{voice_.number});
      } else {
        Feed(voice_event::TimePassed{});
      }
      if (now_ >= end) break;
    }
    now_ = end;
  }
  // What was said since the last call, once there is nothing more to say.
  std::vector<std::string> Said(Duration within = std::chrono::seconds(60)) {
    Wait(within);
    return std::exchange(said_, {});
  }
  void Start() {
    machine_.phase = Phase::kStarting;
    Show();
    machine_.phase = Phase::kRunning;
    Show();
  }
  // Up, and nothing left to be said.
  void BringUp() {
    machine_.loaded = true;
    machine_.battery = 80;
    Start();
    Said();
  }
  void SetBattery(int percent, bool charging = false) {
    machine_.battery = percent;
    machine_.charging = charging;
    machine_.level = LevelAt(*config_.policy->battery, percent, machine_.level);
    machine_.empty = machine_.level == BatteryLevel::kEmpty;
    Show();
  }
  void Fail(const std::string& actuator, std::int32_t code, const std::string& message = "broken") {
    machine_.faults.push_back({actuator, {code, message}});
  }
  void Record(const std::string& kind, CommandNumber number, std::int32_t code,
              const std::string& message = "") {
    Feed(voice_event::Recorded{{kind, std::nullopt, number, code, message}});
  }

  MachineConfig config_ = ManagedConfig();
  VoiceState voice_;
  MachineSummary machine_;
  Time now_{std::chrono::seconds(1000)};
  bool answers_ = true;
  std::optional<Time> answer_at_;
  std::vector<std::string> said_;
};

}  // namespace musher::cyberdog
