#include "musher/modules/vision/course/course_parameters.hpp"

#include "musher/base/code.hpp"

namespace musher::vision {

CourseDetectorMaker ReadCourseParameters(CourseKind, config_toml::TableReader&) {
  return []() -> Result<std::unique_ptr<CourseDetector>> {
    return Error{MakeCode(ModuleCode::kFace, KeyCode::kDeviceError), "there is no such detector"};
  };
}

}  // namespace musher::vision
