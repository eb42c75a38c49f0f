#include "musher/modules/skills/plan/plan_check.hpp"

#include <set>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"

namespace musher::skills {
namespace {

constexpr std::size_t kMostErrors = 20;

class Check {
 public:
  explicit Check(const msg::SkillPlan& plan) : plan_(plan) {
    if (plan.steps.empty()) Add("the plan has no steps");
    for (std::size_t i = 0; i < plan.steps.size(); ++i) CheckStep(i);
  }

  Result<> verdict() const {
    if (count_ == 0) return Ok();
    const std::string more =
        count_ > kMostErrors ? "\nand " + std::to_string(count_ - kMostErrors) + " more" : "";
    return Error{kCodeParametersInvalid, errors_ + more};
  }

 private:
  void Add(const std::string& error) {
    if (++count_ <= kMostErrors) errors_ += (errors_.empty() ? "" : "\n") + error;
  }

  void CheckStep(std::size_t index) {
    const std::string place = StepText(plan_, index);
    const auto& robots = plan_.steps[index].robots;
    if (robots.empty()) Add(place + ": has no robots");
    std::set<std::string> names;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const msg::RobotSkill& robot = robots[i];
      if (!config_toml::IsName(robot.robot_id)) {
        Add(place + ", robot " + std::to_string(i + 1) + ": " + config_toml::Quote(robot.robot_id) +
            " is not the name of a robot; expected " + std::string(config_toml::kNameRule));
        continue;
      }
      const std::string here = place + ", " + robot.robot_id + ": ";
      if (!names.insert(robot.robot_id).second) Add(here + "is in this step twice");
      if (robot.skill_list.size() != 1) {
        Add(here + "expected one skill in skill_list, found " +
            std::to_string(robot.skill_list.size()));
      } else if (robot.skill_list.front().skill.empty()) {
        Add(here + "the skill has no name");
      }
    }
  }

  const msg::SkillPlan& plan_;
  std::string errors_;
  std::size_t count_ = 0;
};

}  // namespace

std::string StepText(const msg::SkillPlan& plan, std::size_t index) {
  return "step " + std::to_string(index + 1) + " (timestep " +
         std::to_string(plan.steps[index].timestep) + ")";
}

Result<> CheckPlan(const msg::SkillPlan& plan) {
  return Check(plan).verdict();
}

}  // namespace musher::skills
