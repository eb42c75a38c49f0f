#pragma once
// The skill take_photo: writes the next picture of a camera as a PNG file, or keeps it in its data.
//
//   INITIALIZING  checks the camera and the path, and waits until a `target` is in sight: 5 s;
//   waits
//                 0.5 s before another attempt
//   EXECUTING     takes a picture    5 s: fails; a failure is retried twice
//   SAVING        writes the file    10 s: fails; a failure fails it
//
// Without a save_path nothing is written: the data photo_data has the picture, a file of the format
// PPM (P6) in base64, until the skill is started again. The data are those of skill::Run::Save().
//
// Details: path, width, height (pixels); of a target those of sight.hpp.

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
  // Whether the target of the parameters, if there is one, is in sight.
  bool SeesTarget(skill::Tick& tick) const;
  skill::Next Capture(skill::Tick& tick);
  static skill::Next Keep(const Picture& picture, skill::Tick& tick);
  skill::Next Save(skill::Tick& tick);

  Robot& robot_;
  skill::StateId initializing_ = skill::kIdle;
  skill::StateId executing_ = skill::kIdle;
  skill::StateId saving_ = skill::kIdle;
  skill::Future<Picture> picture_;
  skill::Future<std::string> file_;
};

}  // namespace musher::skills
