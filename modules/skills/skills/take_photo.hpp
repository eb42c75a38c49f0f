#pragma once
// The skill take_photo: writes the next picture of a camera as a PNG file, or keeps it in its data.
//
//   INITIALIZING  checks the camera and the path, and waits until the place of a `target` is known:
//                 5 s; waits 0.5 s before another attempt
//   AIMING        turns the body towards the target, through the gate, until it looks there within
//                 0.1 rad and stands: 15 s; where the gate stops it, or the time is over, a target
//                 that is in the picture is enough, else it fails
//   EXECUTING     takes a picture    5 s: fails; a failure is retried twice
//   SAVING        writes the file    10 s: fails; a failure fails it
//
// Without a save_path nothing is written: the data photo_data has the picture, a file of the format
// PPM (P6) in base64, until the skill is started again. The data are those of skill::Run::Save().
//
// It uses the base for a target only, and turns with `turn = true` only; without it, and as a flyer
// on the ground, it waits in INITIALIZING until the target is ahead. A flyer in the air keeps its
// place meanwhile. The place of a target is one that was seen lately: by Robot::Detect().
//
// Details: path, width, height (pixels); of a target those of sight.hpp.

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/position_hold.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {

class TakePhoto : public skill::Skill {
 public:
  explicit TakePhoto(Robot& robot) : robot_(robot) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;
  void OnEnd(const skill::Ended& ended) override;
  void OnPause() override;

 private:
  skill::Next Initialize(skill::Tick& tick);
  // What it knows of the target; nullopt: neither its place nor its own.
  struct Aim {
    navigation::Pose own;
    navigation::Point target;
    double off_rad = 0;  // from straight ahead, to the left
  };
  std::optional<Aim> AimAt(skill::Tick& tick) const;
  // Why it knows nothing of it.
  std::string WhyNoAim(const std::string& target) const;
  bool Turns(const skill::Tick& tick, const Aim& aim) const;
  skill::Next FindTarget(skill::Tick& tick);
  skill::Next TurnToTarget(skill::Tick& tick);
  void Turn(const Aim& aim, const skill::Tick& tick);
  // It does not turn any farther: a target in the picture is enough.
  skill::Next EndTurn(const std::optional<Aim>& aim, const std::string& why);
  void StopTurn();
  skill::Next Capture(skill::Tick& tick);
  static skill::Next Keep(const Picture& picture, skill::Tick& tick);
  skill::Next Save(skill::Tick& tick);

  Robot& robot_;
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId aiming_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
  skill::StateId saving_ = skill::kIdle;
  skill::Future<Picture> picture_;
  skill::Future<std::string> file_;
  std::optional<navigation::Pose> place_;  // of a flyer that turns
  PositionHold hold_;
  bool turning_ = false;  // a command is sent
  Duration held_{};       // by the gate
  Duration unknown_{};    // the place of the target
};

}  // namespace musher::skills
