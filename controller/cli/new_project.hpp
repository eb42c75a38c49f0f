#pragma once
// A project from a template: the example new_<kind>, with its names replaced.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cli {

// A name in the spellings that a project uses.
struct ProjectName {
  std::string snake;  // "left_arm": actuator, files, targets
  std::string camel;  // "LeftArm": class

  // From either spelling. The error says which part of `name` is not permitted.
  static Result<ProjectName> From(std::string_view name);
};

// The text with new_<kind> and New<Kind> replaced.
std::string Renamed(std::string text, const std::string& kind, const ProjectName& name);

// The folder with the templates, found from that of the program; empty: not installed.
std::filesystem::path TemplatesFolder(const std::filesystem::path& program);

// Makes `folder` from the template of `kind` ("module", "app", "robot"): all of it or nothing. The
// folder must not exist, or be empty. Returns its files, relative to it, sorted.
Result<std::vector<std::string>> MakeProject(const std::filesystem::path& templates,
                                             const std::string& kind, const ProjectName& name,
                                             const std::filesystem::path& folder);

}  // namespace musher::cli
