#pragma once
// The skill take_photo: writes the next picture of a camera as a PNG file.
//
//   INITIALIZING  checks the camera and the path; waits 0.5 s before another attempt
//   EXECUTING     takes a picture    5 s: fails; a failure is retried twice
//   SAVING        writes the file    10 s: fails; a failure fails it
//
// Details: path, width, height (pixels).

#include "musher/behavior/skill/skill.hpp"
#include "musher/modules/skills/robot/robot.hpp"

namespace musher::skills {

class TakePhoto : public skill::Skill {
 public:
  explicit TakePhoto(Robot& robot) : robot_(robot) {}

  void Declare(skill::Table& table) override;
  skill::Next Step(skill::Tick& tick) override;
  skill::Next OnLimit(skill::Tick& tick) override;

 private:
  skill::Next Initialize(skill::Tick& tick);
  skill::Next Capture(skill::Tick& tick);
  skill::Next Save(skill::Tick& tick);

  Robot& robot_;
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
  skill::StateId saving_ = skill::kIdle;
  skill::Future<Picture> picture_;
  skill::Future<std::string> file_;
};

}  // namespace musher::skills
