// musher explain KEY: what a key of a state config means, from the reference.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/key_reference.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {
namespace {

struct ExplainOptions {
  std::vector<std::string> words;  // "policy.battery.topic", or "[view]" "port"
};

std::string ExplainText(const std::vector<KeyReference>& keys, bool colour) {
  std::string text;
  for (const KeyReference& key : keys) {
    if (!text.empty()) text += '\n';
    text += Paint(key.table + (key.key.empty() ? "" : " " + key.key), Style::kBold, colour) + '\n';
    text +=
        "  type     " + key.type + "\n  default  " + key.otherwise + "\n  " + key.meaning + '\n';
  }
  return text;
}

std::string ExplainJson(const std::vector<KeyReference>& keys) {
  OrderedJson list = OrderedJson::array();
  for (const KeyReference& key : keys) {
    list.push_back({{"table", key.table},
                    {"key", Known(key.key)},
                    {"type", key.type},
                    {"default", key.otherwise},
                    {"meaning", key.meaning}});
  }
  return JsonLine({{"keys", list}});
}

ExitCode Explain(const ExplainOptions& options, const GlobalOptions&, Console& console) {
  std::string words;
  for (const std::string& word : options.words) words += (words.empty() ? "" : " ") + word;
  const auto keys = FindKeys(words);
  if (!keys) return console.Fail({ExitCode::kUsage, keys.error()});
  console.Print(console.mode().json ? ExplainJson(keys.value())
                                    : ExplainText(keys.value(), console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace

void AddExplain(Grammar& grammar) {
  auto [app, options] = grammar.Add("explain", "Show what a key of a state config means", Explain,
                                    "musher explain policy.battery.protected_at");
  app.add_option("KEY", options.words, "restart, policy.battery.topic, or a table: view")
      ->required()
      ->type_name("");
}

}  // namespace musher::cli
