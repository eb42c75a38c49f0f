#pragma once
// Reads a competition field and its robots: [field], [[kfs]], [r2] and [r1]. Reports errors, as
// TableReader does.

#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/world/scene/scene.hpp"
#include "musher/modules/world/scene_file/scene_course.hpp"

namespace musher::world {

void ReadField(config_toml::TableReader& root, const Choices& choices,
               config_toml::Findings& findings, Scene& scene);

}  // namespace musher::world
