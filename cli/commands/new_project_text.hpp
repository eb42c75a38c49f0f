#pragma once
// The output of `musher new`.

#include <string>
#include <vector>

#include "musher/cli/commands/new_project.hpp"

namespace musher::cli {

// The files, and the commands to type next.
std::string NewProjectText(const Project& project, const ProjectName& name,
                           const std::string& folder, const std::vector<std::string>& files);
std::string NewProjectJson(const Project& project, const ProjectName& name,
                           const std::string& folder, const std::vector<std::string>& files);

}  // namespace musher::cli
