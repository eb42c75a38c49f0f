#pragma once
// The kettle as an actuator of the robot.

#include <optional>

#include "kettle.hpp"
#include "musher/application/skill_actuator.hpp"

class Kitchen : public musher::SkillActuator {
 public:
  Kitchen() : SkillActuator("kitchen") {}

 private:
  musher::Result<> RegisterSkills(skill::Registry& registry) override {
    return registry.Add<Heat>("heat", kettle_);
  }
  musher::Result<> SelfCheck() override {
    if (kettle_.water_l > 0) return musher::Ok();
    return musher::Error{6201, "the kettle is empty"};
  }
  void BeforeTick(musher::Time now) override {
    if (last_) kettle_.Advance(now - *last_);
    last_ = now;
  }

  Kettle kettle_;
  std::optional<musher::Time> last_;
};
