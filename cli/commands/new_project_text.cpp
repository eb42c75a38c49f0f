#include "musher/cli/commands/new_project_text.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/printable.hpp"

namespace musher::cli {

std::string NewProjectText(const Project& project, const ProjectName& name,
                           const std::string& folder, const std::vector<std::string>& files) {
  std::string text = fmt::format("{} {} in {}: {}\n\nnext:\n  cd {}\n", project.kind, name.snake,
                                 Printable(folder), Joined(files), Printable(ShellWord(folder)));
  if (project.python()) {
    text += "  python3 " + name.snake + "_test.py\n";
  } else if (project.kind != "robot") {
    text +=
        "  cmake -B build && cmake --build build\n  ctest --test-dir build --output-on-failure\n";
  }
  text += "  musher check robot.toml\n  musher up --detach robot.toml\n";
  text += project.kind == "app" ? "  musher behavior " + name.snake + " --send go\n"
                                : std::string("  musher set LowPower\n");
  return text + "  musher down\n";
}

std::string NewProjectJson(const Project& project, const ProjectName& name,
                           const std::string& folder, const std::vector<std::string>& files) {
  return JsonLine({{"kind", project.kind},
                   {"language", Known(project.language)},
                   {"name", name.snake},
                   {"folder", folder},
                   {"files", files}});
}

}  // namespace musher::cli
