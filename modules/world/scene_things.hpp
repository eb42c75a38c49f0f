#pragma once
// What stands, lies and is painted in a scene: the tables of a scene file for it, and what it looks
// like.

#include <string>

#include "musher/lifecycle/toml/table_reader.hpp"
#include "musher/modules/world/scene.hpp"

namespace musher::world {

// [[box]], [[wall]], [[circle]], [[ball]], [[board]], [[line]] and [[pad]]. Pictures are relative
// to `folder`.
void ReadThings(config_toml::TableReader& root, const std::string& folder,
                config_toml::Findings& findings, Scene& scene);

// [guests] and [[guest]]. After everything else: where guests go is judged by what is in their way.
void ReadGuests(config_toml::TableReader& root, config_toml::Findings& findings, Scene& scene);

// [ground], [light], [cameras] and [camera.*].
void ReadViews(config_toml::TableReader& root, const std::string& folder,
               config_toml::Findings& findings, Scene& scene);

}  // namespace musher::world
