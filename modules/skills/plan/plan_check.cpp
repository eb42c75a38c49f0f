#include "musher/modules/skills/plan/plan_check.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"

namespace musher::skills {
namespace {

constexpr std::size_t kMostErrors = 20;

struct Place {
  double x_m = 0;
  double y_m = 0;
  double z_m = 0;
  std::size_t step = 0;  // since which a robot is there
};

// Of "[2.0, 3.0]" or "[2.0, 3.0, 0.5]"; nullopt: the text is another one, which its skill refuses.
std::optional<Place> PlaceOf(const std::string& text, std::size_t step) {
  double numbers[3] = {};
  std::size_t count = 0;
  const char* at = text.c_str();
  while (*at == ' ' || *at == '[') ++at;
  for (char* end = nullptr; count < 3; at = end, ++count) {
    while (*at == ' ' || *at == ',') ++at;
    numbers[count] = std::strtod(at, &end);
    if (end == at) break;
  }
  const bool finite = std::isfinite(numbers[0]) && std::isfinite(numbers[1]);
  if (count < 2 || !finite) return std::nullopt;
  return Place{numbers[0], numbers[1], numbers[2], step};
}

bool IsOnePlace(const Place& a, const Place& b) {
  constexpr double kBodiesM = 0.4;  // of two robots
  constexpr double kHeightM = 0.5;  // a flyer above a robot on the ground
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < kBodiesM && std::abs(a.z_m - b.z_m) < kHeightM;
}

class Check {
 public:
  explicit Check(const msg::SkillPlan& plan) : plan_(plan) {
    if (plan.steps.empty()) Add("the plan has no steps");
    for (std::size_t i = 0; i < plan.steps.size(); ++i) {
      CheckStep(i);
      CheckPlaces(i);
    }
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

  // Where the robots are after this step, as far as the plan says it.
  void CheckPlaces(std::size_t index) {
    for (const msg::RobotSkill& robot : plan_.steps[index].robots) {
      places_.erase(robot.robot_id);
      if (robot.skill_list.size() != 1) continue;
      for (const msg::SkillParameter& parameter : robot.skill_list.front().params) {
        if (parameter.key != "goal_pos") continue;
        if (const auto place = PlaceOf(parameter.value, index)) places_[robot.robot_id] = *place;
      }
    }
    for (auto a = places_.begin(); a != places_.end(); ++a) {
      for (auto b = std::next(a); b != places_.end(); ++b) {
        const bool new_here = a->second.step == index || b->second.step == index;
        if (new_here && IsOnePlace(a->second, b->second)) AddOnePlace(index, *a, *b);
      }
    }
  }

  using NamedPlace = std::pair<const std::string, Place>;
  void AddOnePlace(std::size_t index, const NamedPlace& a, const NamedPlace& b) {
    const NamedPlace& goes = a.second.step == index ? a : b;
    const NamedPlace& other = &goes == &a ? b : a;
    char place[80];
    std::snprintf(place, sizeof place, "(%.2f, %.2f)", goes.second.x_m, goes.second.y_m);
    const std::string here = StepText(plan_, index) + ": ";
    if (other.second.step == index) {
      return Add(here + goes.first + " and " + other.first + " both go to " + place +
                 "; send one of them to another place");
    }
    Add(here + goes.first + " goes to " + place + ", where " + other.first + " is since step " +
        std::to_string(other.second.step + 1) + "; send " + other.first + " away first");
  }

  const msg::SkillPlan& plan_;
  std::map<std::string, Place> places_;  // by robot
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
