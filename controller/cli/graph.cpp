// musher graph FILE: the states or the actuators of a config as a drawing.

#include <fstream>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/config_file.hpp"
#include "musher/controller/cli/render/graph.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/svg.hpp"

namespace musher::cli {
namespace {

std::string FormatOf(const GraphOptions& options) {
  if (!options.format.empty()) return options.format;
  const auto ends_in = [&](std::string_view end) { return options.output.ends_with(end); };
  if (ends_in(".svg")) return "svg";
  return ends_in(".mmd") || ends_in(".mermaid") ? "mermaid" : "dot";
}

Result<std::string> Draw(const MachineConfig& config, const std::string& what,
                         const std::string& format) {
  const bool flow = what == "flow";
  if (format == "mermaid") return flow ? FlowMermaid(config) : ActuatorsMermaid(config);
  const std::string dot = flow ? FlowDot(config) : ActuatorsDot(config);
  return format == "svg" ? RenderSvg(dot) : Result<std::string>(dot);
}

}  // namespace

ExitCode Graph(const GraphOptions& options, Console& console) {
  const auto config = LoadConfig(options.file, console);
  if (!config) return ExitCode::kUsage;
  const std::string format = FormatOf(options);
  const auto drawing = Draw(*config, options.what, format);
  if (!drawing) return console.Fail({ExitCode::kUsage, drawing.error()});
  if (options.output.empty()) {
    console.Print(console.mode().json ? GraphJson(format, drawing.value()) : drawing.value());
    return ExitCode::kDone;
  }
  std::ofstream file(options.output);
  file << drawing.value();
  file.close();
  if (!file) {
    return console.Fail({ExitCode::kUsage, {kCodeFailed, "cannot write " + options.output}});
  }
  if (console.mode().json) console.Print(GraphFileJson(format, options.output));
  return ExitCode::kDone;
}

}  // namespace musher::cli
