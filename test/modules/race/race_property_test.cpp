// Invariants for random inputs in any order and at any pace.

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "musher/behavior/fsm/replay.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::race_property_test {

// One input of `kind`, or the time until the next.
void Inject(Rig& rig, int kind, int value) {
  static const std::vector<std::string> kCommands = {
      "START",        "STOP",        "RESET",       "START:IN_A1",   "START:QRA_TO_A1",
      "START:IN_QRB", "START:10",    "EXIT_B_ZONE", "SET_QR_A:A-2",  "SET_QR_B_DEFAULT",
      "SET_ARROW:x",  "START:IN_B1", "START:39",    "START:S2_TO_L1"};
  static const std::vector<std::string> kTexts = {"A-1", "A-2", "B-1", "B-2", "left", "", "?"};
  static const std::vector<std::string> kPhases = {"", "seen", "top", "disappeared", "tracking"};
  static const std::vector<std::string> kWords = {"left", "right", "center", "front", "back", "up"};
  const auto of = [value](const auto& list) {
    return list[static_cast<std::size_t>(value) % list.size()];
  };
  const Index detector = static_cast<Index>(value) % (rig.course_.detectors.size() + 1);
  switch (kind) {
    case 0:
      return rig.Command(of(kCommands));
    case 1:
      return rig.race->OnSighting(detector,
                                  {value % 3 != 0, value / 50.0 - 0.1, of(kPhases), of(kTexts)},
                                  rig.now - Milliseconds(value * 20), rig.now);
    case 2:
      return rig.race->OnLines(detector, static_cast<std::uint32_t>(value % 4), of(kWords),
                               "center", value / 50.0 - 1, rig.now - Milliseconds(value), rig.now);
    case 3:
      rig.script.body_status = value % 10 == 0 ? 8 : 0;
      return;
    case 4:
      return rig.race->OnServoReply(value % 4 != 0, 3001, rig.now);
    case 5:
      rig.script.motion = [value](std::int32_t) -> Result<> {
        return value % 5 == 0 ? Result<>(Error{3028, "failed"}) : Ok();
      };
      return;
    case 6:
      if (rig.race->resting()) return rig.race->Resume(rig.now);
      rig.race->Pause(rig.now);
      return rig.machine->Pause();
    case 7:
      return rig.race->OnWalkerStatus(0, value % 2 == 0 ? "State:WALKING" : "x,End:lost", rig.now);
    case 8:
      return rig.race->OnMotionDone(static_cast<std::uint64_t>(value), Ok(), rig.now);
    case 10:
      rig.script.odometry = value % 7 == 0 ? nullptr : Truth;
      rig.script.slip = value / 100.0 - 0.3;
      if (value % 10 == 0) rig.pose.at.x_m += value / 50.0;
      if (value % 11 == 0) rig.pose.at.x_m = kUnknown;
      if (value % 13 == 0) rig.pose = {};
      return;
    default:
      return rig.Tick(value);
  }
}

RC_GTEST_PROP(RaceProperty, NeverLeavesAStreamWithoutItsEndAndIsReplayedIdentically,
              (std::vector<std::uint16_t> inputs)) {
  Rig rig;
  rig.Command("START");
  for (const std::uint16_t input : inputs) {
    Inject(rig, input % 11, input / 11 % 100);
    RC_ASSERT(rig.machine->running());
    RC_ASSERT(rig.machine->counts().faults == 0U);
    RC_ASSERT(rig.field.streams - rig.field.ends == (rig.field.streaming ? 1 : 0));
    if (rig.race->resting()) RC_ASSERT(!rig.field.streaming);
  }
  rig.race->Pause(rig.now);
  RC_ASSERT(!rig.field.streaming);
  RC_ASSERT(rig.field.streams == rig.field.ends);

  const auto read = fsm::ReadRecording(rig.recording, "wild.record");
  RC_ASSERT(read.ok());
  Field field;
  fsm::Machine machine({.name = "race"});
  Race race(rig.course_, field);
  RC_ASSERT(race.Build(machine).ok());
  race.Resume({});
  const auto replayed = fsm::Replay(
      read.value(), machine,
      [&](std::string_view input, std::string_view text) { return race.Apply(input, text); });
  RC_ASSERT(replayed.ok());
  RC_ASSERT(replayed.value().difference.value_or("") == "");
  RC_ASSERT(field.frames == rig.field.frames);
  RC_ASSERT(race.InfoText() == rig.race->InfoText());
}

// Whatever the perception shows: each state is left within the limits of its steps.
RC_GTEST_PROP(RaceProperty, LeavesEveryStateWithinItsLimits, (std::uint32_t seed)) {
  Rig rig;
  std::uint32_t state = seed | 1U;
  const auto random = [&state](std::uint32_t below) {
    state = state * 1'664'525U + 1'013'904'223U;
    return (state >> 8U) % below;
  };
  static const std::vector<std::string> kTexts = {"A-1", "A-2", "B-1", "B-2", "left", "right"};
  static const std::vector<std::string> kPhases = {"", "seen", "top", "disappeared"};
  rig.script.sight = [&](const std::string& detector) -> Sighting {
    const bool seen = detector != "light" && random(40) == 0;
    return {seen, 1, seen ? kPhases[random(4)] : "", kTexts[random(6)]};
  };
  rig.script.lines = [&](const std::string&) {
    return Lines{random(3), static_cast<LineWord>(random(5)), static_cast<LineWord>(random(5))};
  };
  rig.script.walker = [&](Duration) -> std::string {
    const std::uint32_t what = random(300);
    return what == 0 ? "State:IDLE,End:course_end" : what == 1 ? "x,End:lost" : "State:WALKING";
  };
  rig.script.odometry = [&](OdometrySample truth) -> std::optional<OdometrySample> {
    if (random(50) == 0) return std::nullopt;
    return truth;
  };
  rig.script.slip = random(100) / 100.0 - 0.3;
  rig.script.motion = [&](std::int32_t) -> Result<> {
    return random(60) == 0 ? Result<>(Error{3028, "failed"}) : Ok();
  };
  const Index begin = random(static_cast<std::uint32_t>(rig.course_.states.size()));
  rig.Command("START:" + rig.course_.states[begin].name);
  for (int i = 0; i < 60; ++i) {
    const std::string before(rig.state());
    const Index index = FindByName(rig.course_.states, before).value();
    if (index == rig.course_.start || index == rig.course_.end || index == rig.course_.error) break;
    // Ticks between the steps are not in the limits.
    const Duration limit = LongestStay(rig.course_, index) + std::chrono::seconds(5);
    const bool left = rig.RunUntil([&] { return rig.state() != before; }, limit);
    if (!left) RC_FAIL(before + " is not left");
  }
}

}  // namespace musher::race::race_property_test
