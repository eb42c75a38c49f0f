#pragma once
// A player in virtual time, with its last actions.

#include <gmock/gmock.h>

#include <string>
#include <utility>
#include <vector>

#include "musher/modules/audio/player.hpp"

namespace musher::audio::testing {

inline Phrases ThePhrases() {
  return Phrases({{60, 60, {{{Language::kEnglish, "all well"}, {Language::kChinese, "正常"}}, {}}},
                  {1000, 1100, {{{Language::kEnglish, "at {number} percent"}}, {}}},
                  {60'000, 60'000, {{}, "/music/waltz.wav"}}});
}

inline constexpr std::size_t kWaitingCues = 1;  // of these: they wait for their turn
inline std::vector<CueTopic> TheCueTopics() {
  const Cues cues = {
      {"greeting", {{{{Language::kEnglish, "welcome"}, {Language::kChinese, "欢迎"}}, {}}}},
      {"shutter", {{{}, "/sounds/shutter.wav"}}},
      {"fire", {{{{Language::kEnglish, "fire"}}, {}}, true}},
      {"by the way", {{{{Language::kEnglish, "by the way"}}, {}}, false}}};
  return {{"/show/play", true, cues}, {"show/say", false, cues}};
}

class Harness {
 public:
  // The actions of an event.
  template <class Event>
  PlayActions Do(Event event) {
    actions_ = Step(rules_, player_, PlayEvent(std::move(event)), now_);
    return actions_;
  }
  PlayActions Pass(Duration time) {
    now_ += time;
    return Do(play_event::TimePassed{});
  }

  PlayActions Say(CallToken token, const std::string& text, bool is_goal = false) {
    return Do(play_event::PlayRequested{{token, "app", true, 0, text, is_goal}});
  }
  PlayActions PlayId(CallToken token, std::uint16_t id, bool is_goal = false) {
    return Do(play_event::PlayRequested{{token, "app", false, id, {}, is_goal}});
  }
  PlayActions Cue(std::size_t topic, const std::string& id) {
    return Do(play_event::CueRequested{topic, id});
  }
  // The present sound is made, and begins.
  PlayActions Made() { return Do(play_event::Made{Number(), {}}); }
  PlayActions Ended() { return Do(play_event::Ended{Number(), {}}); }

  // The actions of the last event of one kind.
  template <class Action>
  std::vector<Action> Those() const {
    std::vector<Action> those;
    for (const PlayAction& action : actions_) {
      if (const auto* one = std::get_if<Action>(&action)) those.push_back(*one);
    }
    return those;
  }
  std::vector<play_action::Answer> Answers() const { return Those<play_action::Answer>(); }
  std::string LogText() const {
    std::string text;
    for (const auto& log : Those<play_action::Log>()) text += log.text;
    return text;
  }

  SoundNumber Number() const { return player_.current ? player_.current->number : 0; }
  Player& player() { return player_; }
  Time& now() { return now_; }

 private:
  const Phrases phrases_ = ThePhrases();
  const std::vector<CueTopic> cue_topics_ = TheCueTopics();
  const PlayRules rules_{phrases_, Language::kEnglish, 100, cue_topics_};
  Time now_ = Time{} + std::chrono::hours(1);
  Player player_;
  PlayActions actions_;
};

}  // namespace musher::audio::testing
