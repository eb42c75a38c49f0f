#include "musher/modules/meilin/mission/tree_tool.hpp"

#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/files.hpp"
#include "musher/behavior/tree/build.hpp"
#include "musher/behavior/tree/models.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/modules/meilin/mission/match_config.hpp"
#include "musher/modules/meilin/mission/mission_config.hpp"
#include "musher/modules/meilin/mission/ros_robot.hpp"
#include "musher/modules/meilin/nodes/register.hpp"

namespace musher::meilin {
namespace {

// A factory with the nodes of a match, whose robot has no topics.
struct Nodes {
  RosRobot robot{""};
  Settings settings;
  tree::Factory factory;

  Nodes() { static_cast<void>(RegisterNodes(factory, robot, settings)); }
};

int CheckTree(const std::string& file) {
  const Nodes nodes;
  const tree::Reading reading = tree::ReadTreeFile(file);
  for (const Diagnostic& each : reading.diagnostics) std::cerr << FormatDiagnostic(each) << '\n';
  if (!reading.ok()) return program::kUsageError;
  const tree::Built built = tree::Build(reading.document, nodes.factory);
  for (const Diagnostic& each : built.diagnostics) std::cerr << FormatDiagnostic(each) << '\n';
  if (built.tree == nullptr) return program::kUsageError;
  std::cout << file << ": tree " << built.tree->name() << ", " << built.tree->size() << " nodes"
            << std::endl;
  return 0;
}

int CheckMatch(const std::string& file) {
  const MatchReading reading = ReadMatchFile(file);
  for (const std::string& error : reading.errors) std::cerr << error << '\n';
  if (!reading.config) return program::kUsageError;
  std::cout << file << ": " << reading.config->entries.size() << " values of a match" << std::endl;
  return 0;
}

}  // namespace

bool ChecksFile(const std::string& file) {
  if (file.ends_with(".xml")) return true;
  return file.ends_with(".json") && ReadFile(file).find("\"prepare\"") != std::string::npos;
}

int CheckFile(const std::string& file) {
  return file.ends_with(".xml") ? CheckTree(file) : CheckMatch(file);
}

int PrintModels(int argc, const char* const* argv) {
  CLI::App app("Prints the nodes of a match as <TreeNodesModel>.", "musher-meilin models");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : program::kUsageError;
  }
  const Nodes nodes;
  std::cout << tree::ModelsXml(nodes.factory);
  return 0;
}

}  // namespace musher::meilin
