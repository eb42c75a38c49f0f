#include "musher/modules/skills/skills/detect.hpp"

#include <algorithm>

#include "musher/base/suggest.hpp"
#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {
namespace {

// The names and categories, each once, in the order of the alphabet.
std::vector<std::string> Detectable(const std::vector<SeenObject>& objects) {
  std::vector<std::string> names;
  for (const SeenObject& object : objects) {
    names.push_back(object.name);
    if (!object.category.empty()) names.push_back(object.category);
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

void Detect::Declare(skill::Table& table) {
  table.Does("Finds an object by its name or category, however far away");
  table.Needs("target_prim", skill::Kind::kText, "the name or the category of an object");
  table.To(table.State("EXECUTING", std::chrono::seconds(5)), skill::kSucceeded,
           "the target is among the objects");
}

skill::Next Detect::Step(skill::Tick& tick) {
  const std::string target = NameOfPrim(tick.parameters.Text("target_prim"));
  if (target.empty()) return skill::Next::Fail("Object path required");
  const auto pose = robot_.pose();
  const auto objects = robot_.Detect();
  if (!objects || !pose || !navigation::IsFinite(*pose)) {
    tick.Report(50, objects ? "Waiting for odometry" : "Waiting for objects");
    return skill::Next::Stay();
  }
  const auto found = Sightings(*objects, target, *pose, {});
  if (found.empty()) return skill::Next::Fail(NoSuch("object", target, Detectable(*objects)));
  DetailSightings(found, tick);
  std::string text;
  for (const Sighting& sighting : found) {
    text += (text.empty() ? "" : "; ") + SightingText(sighting);
  }
  return skill::Next::Succeed("Detected: " + text);
}

skill::Next Detect::OnLimit(skill::Tick& tick) {
  const std::string why = robot_.Detect() ? robot_.WhyNoPose() : robot_.WhyNothingSeen();
  return skill::Next::Fail("Timeout: " + why + " after " + skill::SecondsText(tick.elapsed));
}

}  // namespace musher::skills
