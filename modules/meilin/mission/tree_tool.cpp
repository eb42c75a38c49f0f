#include "musher/modules/meilin/mission/tree_tool.hpp"

#include <iostream>
#include <memory>
#include <utility>

#include <CLI/CLI.hpp>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/files.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/models.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/modules/meilin/mission/match_config.hpp"
#include "musher/modules/meilin/mission/mission_config.hpp"
#include "musher/modules/meilin/mission/ros_robot.hpp"
#include "musher/modules/meilin/nodes/drawn_form.hpp"
#include "musher/modules/meilin/nodes/register.hpp"

namespace musher::meilin {
namespace {

// A factory with the nodes of a match, whose robot has no topics.
struct Nodes {
  RosRobot robot{{}};
  Settings settings;
  tree::Factory factory;

  Nodes() { static_cast<void>(RegisterNodes(factory, robot, settings)); }
};

std::vector<Diagnostic> CheckTree(const std::string& file) {
  const Nodes nodes;
  tree::Reading reading = tree::ReadTreeFile(file);
  if (!reading.ok()) return std::move(reading.diagnostics);
  std::vector<Diagnostic> found = std::move(reading.diagnostics);
  const std::vector<Diagnostic> drawn = AcceptDrawnForm(reading.document);
  found.insert(found.end(), drawn.begin(), drawn.end());
  tree::Built built = tree::Build(reading.document, nodes.factory);
  found.insert(found.end(), built.diagnostics.begin(), built.diagnostics.end());
  return found;
}

std::vector<Diagnostic> CheckMatch(const std::string& file) {
  std::vector<Diagnostic> found;
  for (std::string error : ReadMatchFile(file).errors) {
    if (error.starts_with(file + ": ")) error.erase(0, file.size() + 2);
    found.push_back({file, 0, 0, Severity::kError, error});
  }
  return found;
}

}  // namespace

std::optional<std::vector<Diagnostic>> CheckTreeOrMatch(const std::string& file) {
  if (file.ends_with(".xml")) return CheckTree(file);
  const bool match =
      file.ends_with(".json") && ReadFile(file).find("\"prepare\"") != std::string::npos;
  if (match) return CheckMatch(file);
  return std::nullopt;
}

int PrintModels(int argc, const char* const* argv) {
  CLI::App app("Prints the nodes of a match as <TreeNodesModel>.", "musher-meilin models");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return EndOfParse(app, error, program::kUsageError);
  }
  const Nodes nodes;
  std::cout << tree::ModelsXml(nodes.factory);
  return 0;
}

}  // namespace musher::meilin
