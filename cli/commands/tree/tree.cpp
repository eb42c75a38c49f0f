// musher tree, musher tree show FILE and musher tree models: behaviour trees in files. Use no
// network.

#include <CLI/CLI.hpp>

#include "musher/base/diagnostic.hpp"
#include "musher/behavior/tree/models.hpp"
#include "musher/behavior/tree/nav2/nodes.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/tree/tree_commands.hpp"
#include "musher/cli/config/tree_file.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/tree.hpp"

namespace musher::cli {
namespace {

struct TreeShowOptions {
  std::string file;
  std::string tree;  // empty: the main one
};

ExitCode ShowTreeFile(const TreeShowOptions& options, const GlobalOptions& /*global*/,
                      Console& console) {
  const tree::Reading reading = tree::ReadTreeFile(options.file);
  for (const Diagnostic& each : reading.diagnostics) console.Note(FormatDiagnostic(each));
  if (!reading.ok()) {
    if (console.mode().json) console.Print(CheckJson(reading.diagnostics));
    return ExitCode::kUsage;
  }
  const auto nodes = NodesOf(reading.document, options.tree);
  if (!nodes) {
    return console.Fail({nodes.error().code, options.file + ": " + nodes.error().message});
  }
  console.Print(console.mode().json ? FileTreeJson(nodes.value())
                                    : FileTreeText(nodes.value(), console.mode().colour));
  return ExitCode::kDone;
}

struct TreeModelsOptions {
  std::string format = "xml";  // or "markdown"
  bool nav2 = false;           // only the nodes of nav2
};

ExitCode PrintModels(const TreeModelsOptions& options, const GlobalOptions& /*global*/,
                     Console& console) {
  tree::Factory factory;
  if (options.nav2) {
    factory = tree::Factory::Empty();
    tree::nav2::AddForCheck(factory);
  }
  const std::string models =
      options.format == "markdown" ? tree::ModelsMarkdown(factory) : tree::ModelsXml(factory);
  console.Print(console.mode().json ? GraphJson(options.format, models) : models);
  return ExitCode::kDone;
}

void AddTreeShow(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("show", "Print the nodes of a tree with their ports", ShowTreeFile, &family);
  grammar.Offer(app.add_option("FILE", options.file, "Behaviour trees (XML)"), Names::kTreeFiles)
      ->required()
      ->type_name("");
  app.add_option("--tree", options.tree,
                 "The tree; default: the main tree, or all where none is the main one")
      ->type_name("ID");
}

void AddTreeModels(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add(
      "models", "Print the models of nodes, for editors such as Groot2", PrintModels, &family);
  grammar.OneOf(app.add_option("--format", options.format, "Default xml"), {"xml", "markdown"});
  app.add_flag("--nav2", options.nav2, "Print those of nav2's nodes instead");
}

}  // namespace

void AddTree(Grammar& grammar) {
  CLI::App& family = grammar.AddFamily("tree", "Check, show and replay behaviour trees in files",
                                       "musher tree check mission.xml");
  AddTreeCheck(grammar, family);
  AddTreeShow(grammar, family);
  AddTreeModels(grammar, family);
  AddTreeReplay(grammar, family);
}

}  // namespace musher::cli
