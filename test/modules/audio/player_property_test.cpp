// Invariants for every order of requests, sounds, failures and times.

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <functional>
#include <map>
#include <set>

#include "musher/test/modules/audio/harness.hpp"

namespace musher::audio::testing::player_property_test {

using Pick = std::function<std::size_t(std::size_t below)>;

// Drives a player with random events and checks every action.
class Trial {
 public:
  explicit Trial(Pick pick) : pick_(std::move(pick)) {}

  // The violated invariant, or nothing.
  std::optional<std::string> Run(int steps) {
    for (int i = 0; i < steps && !broken_; ++i) Look(Next());
    for (int i = 0; i < 100 && !broken_ && (making_ != 0 || playing_ != 0); ++i) Look(Finish());
    Check(open_.empty(), "a call is never answered");
    Check(!harness_.player().current && harness_.player().waiting.empty(), "something never plays");
    Check(!reported_, "sound is reported for ever");
    return broken_;
  }

 private:
  PlayActions Next() {
    switch (pick_(13)) {
      case 0:
        return RequestSound(0);
      case 1:
      case 2:
        return RequestSound(Open(harness_.now() + kAnswerTime));
      case 3:
        return harness_.Do(play_event::StopRequested{Open(harness_.now())});
      case 4:
        return harness_.Do(play_event::VolumeRequested{Open(harness_.now()), Number(150)});
      case 5:
        return Stray(playing_, [](SoundNumber n) { return play_event::Ended{n, {}}; });
      case 6:
        return Stray(making_, [](SoundNumber n) { return play_event::Made{n, {}}; });
      case 7:
        return harness_.Pass(Milliseconds(Number(4'000)));
      case 8: {
        static const std::vector<std::string> ids = {"greeting", "shutter", "fire", "unknown"};
        return harness_.Cue(pick_(2), ids[pick_(ids.size())]);
      }
      case 9:  // a goal has no time limit
        return RequestSound(Open(Time::max()), true);
      case 10:
        return harness_.Do(play_event::CancelRequested{pick_(last_token_ + 2)});
      default:
        return Finish();
    }
  }

  PlayActions RequestSound(CallToken token, bool is_goal = false) {
    static const std::vector<std::string> texts = {"hello", "", "\xFF", std::string(101, 'a')};
    if (pick_(2) == 0) return harness_.Say(token, texts[pick_(texts.size())], is_goal);
    static const std::vector<std::uint16_t> ids = {60, 1050, 4711, 9999};
    return harness_.PlayId(token, ids[pick_(ids.size())], is_goal);
  }

  // An event of a sound that is not in progress, or only seems so.
  template <class MakeEvent>
  PlayActions Stray(SoundNumber true_one, MakeEvent make_event) {
    const SoundNumber number = pick_(20);
    PlayActions actions = harness_.Do(make_event(number));
    Check(number == true_one || actions.empty(), "an ended sound is confused with another");
    return actions;
  }

  // A sound in progress ends, one way or the other.
  PlayActions Finish() {
    const Result<> result = pick_(4) == 0 ? Result<>(Error{5012, "lost"}) : Ok();
    if (making_ != 0) return harness_.Do(play_event::Made{making_, result});
    if (playing_ != 0) return harness_.Do(play_event::Ended{playing_, result});
    return harness_.Pass(Milliseconds(1));
  }

  CallToken Open(Time deadline) {
    open_[++last_token_] = deadline;
    return last_token_;
  }

  void Look(const PlayActions& actions) {
    // Made and Ended of a number in progress are valid from any source.
    const auto* current = harness_.player().current ? &*harness_.player().current : nullptr;
    for (const PlayAction& action : actions) {
      std::visit([this](const auto& a) { See(a); }, action);
    }
    making_ = current != nullptr && !current->sounding ? current->number : 0;
    playing_ = current != nullptr && current->sounding ? current->number : 0;
    for (const auto& [token, deadline] : open_) {
      Check(harness_.now() < deadline, "an answer comes too late");
    }
    Check(harness_.player().waiting.size() <= kMostWaiting, "the queue is too long");
    Check(current != nullptr || harness_.player().waiting.empty(), "one waits for nothing");
    Check(harness_.player().volume <= kFullVolume, "the volume is out of its range");
    Check(playing_ == 0 || reported_, "sound is not reported");
  }
  void See(const play_action::Answer& answer) {
    Check(open_.erase(answer.token) == 1, "a call is answered twice, or was never made");
  }
  void See(const play_action::Make& make) {
    Check(made_.insert(make.number).second, "a sound is made twice");
  }
  void See(const play_action::Play& play) {
    Check(made_.contains(play.number), "a sound is played that was not made");
    Check(played_.insert(play.number).second, "a sound is played twice");
  }
  void See(const play_action::Report& report) { reported_ = report.sounds; }
  void See(const play_action::Silence& /*silence*/) {
    Check(making_ != 0 || playing_ != 0, "nothing is silenced");
  }
  template <class Other>
  void See(const Other& /*other*/) {}

  void Check(bool holds, const char* why) {
    if (!holds && !broken_) broken_ = why;
  }
  int Number(std::size_t below) { return static_cast<int>(pick_(below)); }

  Pick pick_;
  Harness harness_;
  CallToken last_token_ = 0;
  std::map<CallToken, Time> open_;  // and when they have to be answered at the latest
  std::set<SoundNumber> made_;
  std::set<SoundNumber> played_;
  SoundNumber making_ = 0;
  SoundNumber playing_ = 0;
  bool reported_ = false;
  std::optional<std::string> broken_;
};

RC_GTEST_PROP(Player, HoldsItsInvariantsUnderRandomEvents, ()) {
  Trial trial([](std::size_t below) { return *rc::gen::inRange<std::size_t>(0, below); });
  const auto broken = trial.Run(*rc::gen::inRange(1, 150));
  if (broken) RC_FAIL(*broken);
}

// The same from a plain generator, without shrinking and so a lot more of it.
TEST(Player, HoldsItsInvariantsInManyRandomRuns) {
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    std::uint64_t state = seed;
    Trial trial([&](std::size_t below) {
      state = state * 6364136223846793005U + 1442695040888963407U;
      return static_cast<std::size_t>(state >> 33U) % below;
    });
    ASSERT_EQ(trial.Run(200), std::nullopt) << "seed " << seed;
  }
}

}  // namespace musher::audio::testing::player_property_test
