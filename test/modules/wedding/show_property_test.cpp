// Invariants for random inputs in any order and at any pace.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "musher/behavior/fsm/replay.hpp"
#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_property_test {

constexpr int kKinds = 9;

// The rig without a test of its own, driven by random numbers.
class WildShow : public ShowRig {
 public:
  explicit WildShow(bool extended) {
    if (extended) {
      config_.search.emplace();
      config_.interview.emplace();
    }
    Begin(config_);
    for (const fsm::ChartTransition& transition : machine_->chart().transitions)
      transitions_.insert({transition.from, transition.to});
  }
  void TestBody() override {}

  // One input, and the time until the next.
  void Happen(int kind, int value) {
    static const std::vector<std::string> kGestures = {"none", "heart", "v", "ok", "HEART", "wave"};
    static const std::vector<std::string> kCommands = {
        "stop", "photo", "idle", "tracking", "search", "reset", "interview", "dance", "SAFE_STOP"};
    const auto of = [value](const auto& list) {
      return list[static_cast<std::size_t>(value) % list.size()];
    };
    const double share = value / 99.0;
    switch (kind) {
      case 0:
        return Face({share, 1 - share});
      case 1:
        return show_->OnTarget({{share * 3 - 1, std::log(share - 0.5)}, share - 0.1, {}}, now_);
      case 2:
        return Gesture(of(kGestures));
      case 3:
        return TooClose(too_close_ = value % 3 == 0);
      case 4:
        return Command(of(kCommands));
      case 5:
        return show_->OnVoiceCommand(of(kCommands), now_);
      case 6:
        return show_->OnVoiceLevel(share * 2 - 0.5, now_);
      case 7:
        now_ += Milliseconds(value * 20);
        return;
      default:
        return TickOnce(Milliseconds(value));
    }
  }

  void TickOnce(Duration step) {
    const fsm::StateId before = machine_->current();
    step_ = step;
    Tick();
    const fsm::StateId after = machine_->current();
    const bool declared = before == after || transitions_.contains({before, after});
    const fsm::StateId safe = machine_->FindState("SAFE_STOP").value();
    RC_ASSERT(declared || after == safe);
    RC_ASSERT(machine_->running());
    RC_ASSERT(machine_->counts().faults == 0U);
    if (data().perception.too_close) RC_ASSERT(after == safe);
    RC_ASSERT(data().safety_triggered == (after == safe));
    const Gaze gaze = script_.gazes.back();
    RC_ASSERT(gaze.x >= 0 && gaze.x <= 1 && gaze.y >= 0 && gaze.y <= 1);
  }
  void TickFor(Duration time) {
    for (Duration passed{}; passed < time; passed += Milliseconds(20)) TickOnce(Milliseconds(20));
  }
  bool IsHome() const { return state() == "IDLE" && data().motion.current_pose == "neutral"; }
  int photos() const { return script_.photos; }

  // The recording is replayed by another show with the same result.
  void Replay() {
    const auto read = fsm::ReadRecording(recording_, "wild.record");
    RC_ASSERT(read.ok());
    Script script;
    fsm::Machine machine({.name = "wedding"});
    Show show(config_, script);
    RC_ASSERT(show.Build(machine).ok());
    show.Resume({});
    const auto replayed = fsm::Replay(
        read.value(), machine,
        [&](std::string_view input, std::string_view text) { return show.Apply(input, text); });
    RC_ASSERT(replayed.ok());
    RC_ASSERT(replayed.value().difference.value_or("") == "");
    RC_ASSERT(show.state() == state());
    RC_ASSERT(machine.ticks() == machine_->ticks());
    const Gaze gaze = show.data().motion.look_at_target;
    RC_ASSERT(gaze == data().motion.look_at_target);
  }
  void Pause() { show_->Pause(now_); }
  void Resume() { show_->Resume(now_); }

  using ShowRig::Gesture;
  using ShowRig::TickWithFace;
  using ShowRig::TooClose;
  using ShowRig::Track;

 private:
  ShowConfig config_;
  std::set<std::pair<fsm::StateId, fsm::StateId>> transitions_;
  bool too_close_ = false;
};

RC_GTEST_PROP(ShowProperty,
              TakesDeclaredTransitionsOnlyIsSafeInOneTickAndReturnsToIdleWhenLeftAlone,
              (bool extended)) {
  WildShow show(extended);
  const auto events = *rc::gen::container<std::vector<std::pair<int, int>>>(
      200, rc::gen::pair(rc::gen::inRange(0, kKinds), rc::gen::inRange(0, 100)));
  for (const auto& [kind, value] : events) show.Happen(kind, value);
  show.TooClose(false);
  // Some commands wait, each for its tick; the longest path to IDLE is an interview that is due.
  show.TickFor(Milliseconds(20'000));
  RC_ASSERT(show.IsHome());
}

RC_GTEST_PROP(ShowProperty, ReplaysItsRecordingIdentically, (bool extended)) {
  WildShow show(extended);
  const auto events = *rc::gen::container<std::vector<std::pair<int, int>>>(
      200, rc::gen::pair(rc::gen::inRange(0, kKinds), rc::gen::inRange(0, 100)));
  for (const auto& [kind, value] : events) {
    if (kind == 7 && value > 80) {  // the robot goes to LowPower and comes back
      show.Pause();
      show.Resume();
    }
    show.Happen(kind, value);
  }
  show.Replay();
}

RC_GTEST_PROP(ShowProperty, TakesNoMorePhotosThanGesturesWereRaised, ()) {
  WildShow show(false);
  show.Track();
  int raised = 0;
  bool up = false;
  // Raised and lowered, each held for up to 10 s; samples come every 20 ms.
  for (int i = 0; i < 6; ++i) {
    const int held = *rc::gen::inRange(1, 500);
    up = !up;
    raised += up ? 1 : 0;
    for (int tick = 0; tick < held; ++tick) {
      show.Gesture(up ? "heart" : "none");
      show.TickWithFace(1);
    }
  }
  show.TickFor(Milliseconds(10'000));
  RC_ASSERT(show.photos() <= raised);
  RC_ASSERT(show.photos() >= 1);
}

}  // namespace musher::wedding::show_property_test
