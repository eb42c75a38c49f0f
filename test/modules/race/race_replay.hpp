#pragma once
// A race replays its recording.

#include "musher/behavior/fsm/replay.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race {

// Another race of this course replays the recording of the rig: it moves and speaks as that one,
// and ends in its state.
inline void ExpectReplays(const Rig& rig, const Course& course = TheCourse()) {
  const auto read = fsm::ReadRecording(rig.recording, "race.record");
  ASSERT_TRUE(read) << read.error().message;
  Field field;
  fsm::Machine machine({.name = "race"});
  Race race(course, field);
  ASSERT_TRUE(race.Build(machine));
  race.Resume({});
  const auto replayed = fsm::Replay(
      read.value(), machine,
      [&](std::string_view input, std::string_view text) { return race.Apply(input, text); });
  ASSERT_TRUE(replayed) << replayed.error().message;
  EXPECT_EQ(replayed.value().difference.value_or(""), "");
  EXPECT_EQ(race.state(), rig.race->state());
  EXPECT_EQ(race.memory().reserved(), rig.race->memory().reserved());
  EXPECT_EQ(field.frames, rig.field.frames);
  EXPECT_EQ(field.spoken, rig.field.spoken);
}

}  // namespace musher::race
