#pragma once
// The table `parameters` of a detector of a course: ranges are checked, errors are located.

#include <filesystem>

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/vision/course/course_config.hpp"
#include "musher/modules/vision/course/hall.hpp"

namespace musher::vision {

// Reads the parameters of that kind of detector, which looks at the camera's pictures of the topic
// `picture`. What it does not say, the hall does; `folder` is that of the file. A network is
// loaded, which may take a second. The caller refuses other keys.
CourseParameters ReadCourseParameters(CourseKind kind, const Hall& hall, const std::string& picture,
                                      const std::filesystem::path& folder,
                                      config_toml::TableReader& reader,
                                      config_toml::Findings& findings);

// How to make the detector with them, and in which white balance it looks at pictures; words are
// read in them as they are.
CourseFactory FactoryOf(const CourseParameters& parameters,
                        const std::optional<WhiteBalance>& balance = std::nullopt);

}  // namespace musher::vision
