#pragma once
// The skill assembly: the robot brings the part that its hand holds to a station that its detectors
// see, puts it there, and checks by its detectors where it stands then. For robots on the ground.
//
//   station             a name or category that its detectors report
//   object_prim_path    the part; empty: the one that is held
//   offset              [x, y, z] m from the middle of the station to the middle of the underside
//                       of the part, with the axes of the map; default [0, 0, 0]
//   distance            m from the middle of the robot to that of the station, at which the hand
//                       reaches it; default 0.8
//   tolerance           m, level, of the part at its place; default 0.05
//   lost_limit          s at a stand without a sighting of the station that counts; default 2
//
//   INITIALIZING  checks hand, part and parameters; waits 0.5 s before another attempt
//   PREPARING     goes before the station by what it sees (servo_drive.hpp)              60 s
//   EXECUTING     puts the part there, then looks at part and station in 5 pictures      12 s
//   FINALIZING    at a cancellation, waits for the hand                                  3 s
//
// The part stands right if it is within `tolerance` of its place beside the station, as the same
// pictures show both, and not below it. A part that is not seen, or stands elsewhere, fails it: the
// hand has released it by then. A lost reply of the hand is retried three times.

#include <memory>
#include <optional>
#include <string>

#include "musher/behavior/skill/pattern.hpp"
#include "musher/modules/skills/skills/grip.hpp"
#include "musher/modules/skills/skills/servo_drive.hpp"

namespace musher::skills {

class Assembly : public skill::PatternSkill {
 public:
  Assembly(Robot& robot, std::shared_ptr<Grip> grip) : robot_(robot), grip_(std::move(grip)) {}

  skill::Next OnLimit(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;

 private:
  void Describe(skill::Table& table) override;
  Outcome Initialize(skill::Tick& tick) override;
  Outcome Prepare(skill::Tick& tick) override;
  Outcome Execute(skill::Tick& tick) override;
  Outcome Finalize(skill::Tick& tick) override;
  std::optional<std::string> WhyRefused(const skill::Values& parameters) const;
  HandRequest Request(const skill::Tick& tick) const;
  // After the hand has released the part.
  void BeginCheck();
  Outcome Check(skill::Tick& tick);

  Robot& robot_;
  const std::shared_ptr<Grip> grip_;
  HandCall call_;
  std::optional<ServoDrive> drive_;
  // Of the check: from the station to the part, with the axes of the map.
  navigation::Point offsets_;  // their sum
  int pictures_ = 0;
  std::optional<Time> looked_;  // of the last picture, at first the time of the release
};

}  // namespace musher::skills
