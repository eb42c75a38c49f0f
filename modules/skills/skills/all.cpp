#include "musher/modules/skills/skills/all.hpp"

#include "musher/modules/skills/skills/body_skills.hpp"
#include "musher/modules/skills/skills/navigation_skills.hpp"

namespace musher::skills {

Result<> RegisterSkills(skill::Registry& registry, Robot& robot) {
  if (Result<> added = RegisterNavigationSkills(registry, robot); !added) return added;
  return RegisterBodySkills(registry, robot);
}

}  // namespace musher::skills
