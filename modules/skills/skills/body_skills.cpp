#include "musher/modules/skills/skills/body_skills.hpp"

#include <memory>

#include "musher/modules/skills/skills/assembly.hpp"
#include "musher/modules/skills/skills/detect.hpp"
#include "musher/modules/skills/skills/grasp.hpp"
#include "musher/modules/skills/skills/hover.hpp"
#include "musher/modules/skills/skills/land.hpp"
#include "musher/modules/skills/skills/object_detection.hpp"
#include "musher/modules/skills/skills/pick_up.hpp"
#include "musher/modules/skills/skills/place.hpp"
#include "musher/modules/skills/skills/put_down.hpp"
#include "musher/modules/skills/skills/take_off.hpp"
#include "musher/modules/skills/skills/take_photo.hpp"

namespace musher::skills {
namespace {

template <class S>
skill::Factory Made(Robot& robot) {
  return [&robot] { return std::make_unique<S>(robot); };
}

template <class S>
skill::Factory MadeWithGrip(Robot& robot, const std::shared_ptr<Grip>& grip) {
  return [&robot, grip] { return std::make_unique<S>(robot, grip); };
}

}  // namespace

Result<> RegisterBodySkills(skill::Registry& registry, Robot& robot) {
  const auto grip = std::make_shared<Grip>(robot);
  const std::vector<std::pair<const char*, skill::Factory>> skills{
      {"take_off", Made<TakeOff>(robot)},
      {"hover", Made<Hover>(robot)},
      {"land", Made<Land>(robot)},
      {"take_photo", Made<TakePhoto>(robot)},
      {"object_detection", Made<ObjectDetection>(robot)},
      {"detect", Made<Detect>(robot)},
      {"pick_up", MadeWithGrip<PickUp>(robot, grip)},
      {"put_down", MadeWithGrip<PutDown>(robot, grip)},
      {"grasp", MadeWithGrip<Grasp>(robot, grip)},
      {"place", MadeWithGrip<Place>(robot, grip)},
      {"assembly", MadeWithGrip<Assembly>(robot, grip)},
  };
  for (const auto& [name, factory] : skills) {
    if (Result<> added = registry.Add(name, factory); !added) return added;
  }
  return Ok();
}

}  // namespace musher::skills
