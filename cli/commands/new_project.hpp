#pragma once
// A project from a template: the example new_<kind> or new_python_<kind>, with its names replaced.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::cli {

struct Project {
  std::string kind;      // "module", "app", "robot"
  std::string language;  // "cpp", "python"; empty: none

  bool python() const { return language == "python"; }
  // "new_module", "new_python_module"
  std::string Template() const;
};

// A name in the spellings that a project uses.
struct ProjectName {
  std::string snake;  // "left_arm": actuator, files, targets
  std::string camel;  // "LeftArm": class

  // Parses either spelling. The error says which part of `name` is not permitted.
  static Result<ProjectName> From(std::string_view name, const Project& project);
};

// The text with the name of the template replaced in both spellings.
std::string Renamed(std::string text, const Project& project, const ProjectName& name);

// The folder with the templates, found from that of the program; empty: not installed.
std::filesystem::path TemplatesFolder(const std::filesystem::path& program);

// Makes `folder` from the template: all of it or nothing. The folder must not exist, or be empty.
// Returns its files, relative to it, sorted.
Result<std::vector<std::string>> MakeProject(const std::filesystem::path& templates,
                                             const Project& project, const ProjectName& name,
                                             const std::filesystem::path& folder);

}  // namespace musher::cli
