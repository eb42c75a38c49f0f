#include "musher/modules/skills/skills/navigation_skills.hpp"

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/skills/skills/avoid_obstacle.hpp"
#include "musher/modules/skills/skills/explore.hpp"
#include "musher/modules/skills/skills/follow_line.hpp"
#include "musher/modules/skills/skills/move.hpp"
#include "musher/modules/skills/skills/navigate_to.hpp"
#include "musher/modules/skills/skills/recovery_skill.hpp"
#include "musher/modules/skills/skills/track.hpp"
#include "musher/modules/skills/skills/visual_servoing.hpp"

namespace musher::skills {
namespace {

template <class S, class... Options>
skill::Factory MadeFor(Robot& robot, Options... options) {
  return [&robot, options...] { return std::make_unique<S>(robot, options...); };
}

}  // namespace

Result<> RegisterNavigationSkills(skill::Registry& registry, Robot& robot) {
  const std::vector<std::pair<std::string, skill::Factory>> skills{
      {"navigate_to", MadeFor<NavigateTo>(robot)},
      {"nav_2d", MadeFor<NavigateTo>(robot, NavigateTo::For::kGround)},
      {"nav_3d", MadeFor<NavigateTo>(robot, NavigateTo::For::kAir)},
      {"move", MadeFor<Move>(robot)},
      {"explore", MadeFor<Explore>(robot)},
      {"track", MadeFor<Track>(robot)},
      {"follow_line", MadeFor<FollowLine>(robot)},
      {"avoid_obstacle", MadeFor<AvoidObstacle>(robot)},
      {"visual_servoing", MadeFor<VisualServoing>(robot)},
      {"leave_tight_start", MadeFor<RecoverySkill>(robot, RecoveryKind::kLeaveTightStart)},
      {"clear", MadeFor<RecoverySkill>(robot, RecoveryKind::kClear)},
      {"wait", MadeFor<RecoverySkill>(robot, RecoveryKind::kWait)},
      {"back_up", MadeFor<RecoverySkill>(robot, RecoveryKind::kBackUp)},
      {"spin", MadeFor<RecoverySkill>(robot, RecoveryKind::kSpin)},
  };
  for (const auto& [name, make] : skills) {
    Result<> added = registry.Add(name, make);
    if (!added) return added;
  }
  return Ok();
}

}  // namespace musher::skills
