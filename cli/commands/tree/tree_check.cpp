// musher tree check FILE...: reports every error in behaviour trees. Uses no network.

#include <CLI/CLI.hpp>

#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/tree/tree_commands.hpp"
#include "musher/cli/config/tree_file.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"

namespace musher::cli {
namespace {

constexpr const char* kBtcpp = "btcpp-4.10";

struct TreeCheckOptions {
  std::vector<std::string> files;
  TreeFileOptions read;
};

// "tree Patrol, 12 nodes in 2 trees; from models: BatteryOk, Move"
std::string Summary(const TreeFile& file) {
  std::string text = "tree " + file.tree->name() + ", " + Counted(file.tree->size(), "node") +
                     " in " + Counted(file.document.trees.size(), "tree");
  if (!file.placeholders.empty()) text += "; from models: " + Joined(file.placeholders);
  return text;
}

ExitCode CheckTrees(const TreeCheckOptions& options, const GlobalOptions& /*global*/,
                    Console& console) {
  std::vector<Diagnostic> all;
  bool has_unknown = false;
  for (const std::string& name : options.files) {
    const TreeFile file = ReadTreeWithModels(name, options.read);
    has_unknown |= file.has_unknown;
    all.insert(all.end(), file.diagnostics.begin(), file.diagnostics.end());
    if (console.mode().json) continue;
    std::string text;
    for (const Diagnostic& each : file.diagnostics) {
      text += Printable(FormatDiagnostic(each)) + '\n';
    }
    const std::string of_file = options.files.size() > 1 ? Printable(name) + ": " : "";
    if (file.tree != nullptr) text += of_file + "ok: " + Printable(Summary(file)) + '\n';
    console.Print(text);
  }
  if (console.mode().json) {
    console.Print(CheckJson(all));
  } else if (has_unknown && options.read.models.empty()) {
    console.Print(
        "note: <TreeNodesModel> of the file, or --models FILE, describes the nodes that only "
        "your program has; --nav2 those of nav2");
  }
  return HasError(all) ? ExitCode::kUsage : ExitCode::kDone;
}

}  // namespace

void AddTreeCheck(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("check", "Report every error in behaviour trees", CheckTrees, &family);
  grammar.Offer(app.add_option("FILE", options.files, "Behaviour trees (XML)"), Names::kTreeFiles)
      ->required()
      ->type_name("");
  grammar
      .Offer(app.add_option("--models", options.read.models,
                            "Models of the nodes that only your program has (XML)"),
             Names::kTreeFiles)
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("FILE");
  grammar.OneOf(
      app.add_option("--as", options.read.as, "Also warn of what another engine does differently"),
      {kBtcpp});
  app.add_flag("--nav2", options.read.nav2, "Know the nodes of nav2");
  app.add_option("--tree", options.read.tree,
                 "The tree that runs; default: the main tree, or each that no other one uses")
      ->type_name("ID");
}

}  // namespace musher::cli
