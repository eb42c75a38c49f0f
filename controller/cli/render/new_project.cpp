#include "musher/controller/cli/render/new_project.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "musher/controller/cli/render/json_line.hpp"
#include "musher/controller/cli/render/words.hpp"

namespace musher::cli {

std::string NewProjectText(const std::string& kind, const ProjectName& name,
                           const std::string& folder, const std::vector<std::string>& files) {
  std::string text = fmt::format("{} {} in {}: {}\n\nnext:\n  cd {}\n", kind, name.snake, folder,
                                 Join(files), folder);
  if (kind != "robot") {
    text +=
        "  cmake -B build && cmake --build build\n  ctest --test-dir build --output-on-failure\n";
  }
  text += "  musher check robot.toml\n  musher up --detach robot.toml\n";
  text += kind == "app" ? "  musher behavior " + name.snake + " --send go\n"
                        : std::string("  musher set LowPower\n");
  return text + "  musher down\n";
}

std::string NewProjectJson(const std::string& kind, const ProjectName& name,
                           const std::string& folder, const std::vector<std::string>& files) {
  return JsonLine({{"kind", kind}, {"name", name.snake}, {"folder", folder}, {"files", files}});
}

}  // namespace musher::cli
