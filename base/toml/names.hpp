#pragma once
// The syntax of names and paths in a config.

#include <filesystem>
#include <string>
#include <string_view>

namespace musher::config_toml {

inline constexpr std::string_view kNameRule =
    "a name of letters, digits and '_' that begins with no digit, at most 64 long";
inline constexpr std::string_view kNamespaceRule =
    "names separated by '/' that begin with no digit, as in \"fleet/dog1\", at most 200 long";

// Names of machines, actuators and states: what ROS 2 accepts as a node or topic name.
bool IsName(std::string_view text);

// Names separated by '/', or nothing.
bool IsNamespace(std::string_view text);

// A topic as ROS 2 names it, relative to the namespace, "image_rgb", or absolute, "/show/pose".
bool IsTopic(std::string_view text);
bool IsRelativeTopic(std::string_view text);

// The folder of a config file, absolute.
std::filesystem::path FolderOf(const std::string& file);

// The machine's name where the config gives none: the file's stem, with '_' for characters that a
// name cannot have, "machine" where nothing is left.
std::string NameOf(const std::string& file);

// `path` relative to `folder`, made absolute and without "..".
std::string Absolute(const std::filesystem::path& folder, const std::string& path);

// $XDG_STATE_HOME or ~/.local/state, then musher/<name>; below /var/lib without a home.
// Robots that share a host have a folder each: "robot@fleet.dog" in a namespace, "robot.domain7" in
// a domain other than 0 (ROS_DOMAIN_ID).
std::string DefaultStateDir(const std::string& name, const std::string& name_space);

}  // namespace musher::config_toml
