#include "musher/modules/vision/course/course_detection.hpp"

#include <utility>

namespace musher::vision {
namespace {

Error Named(const std::string& name, const Error& error) {
  return {error.code, name + ": " + error.message};
}

}  // namespace

CourseDetection::CourseDetection(const Dependencies& dependencies, const CourseEntry& entry,
                                 const DetectionEvents& events)
    : name_(entry.name),
      check_(entry.factory.check),
      thread_(dependencies.node.loop(),
              [make = entry.factory.make] { return CourseProcessor::Make(make); }, entry.limits,
              {.on_result =
                   [this](const DetectionResult<CourseProcessor>& result) {
                     if (topics_) topics_->OnResult(result);
                   },
               .on_left_out = [this] { topics_->OnLeftOut(); },
               .checkpoint = events.checkpoint,
               .on_detector_lost = [name = entry.name, lost = events.on_lost](
                                       const Error& error) { lost(Named(name, error)); }}) {}

Result<std::unique_ptr<CourseDetection>> CourseDetection::Make(const Dependencies& dependencies,
                                                               const CourseEntry& entry,
                                                               Duration silence,
                                                               const DetectionEvents& events) {
  Dependencies named = dependencies;
  named.log = [name = entry.name, log = dependencies.log](const Error& error) {
    log(Named(name, error));
  };
  std::unique_ptr<CourseDetection> detection(new CourseDetection(named, entry, events));
  auto topics = CourseTopics::Make(named, detection->thread_, entry, silence);
  if (!topics) return Named(entry.name, topics.error());
  detection->topics_ = std::move(topics).value();
  return detection;
}

Result<> CourseDetection::Load() {
  if (!is_checked_) {
    if (const Result<> checked = check_(); !checked) return Named(name_, checked.error());
    is_checked_ = true;
  }
  const Result<> loaded = thread_.Load();
  return loaded ? loaded : Named(name_, loaded.error());
}

}  // namespace musher::vision
