#include "musher/cli/render/diff.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/console/json_line.hpp"

namespace musher::cli {
namespace {

using Kind = ConfigChange::Kind;

std::string TableName(const std::string& table) {
  if (table == "transition") return "[[transition]]";
  if (table.starts_with("state.")) return "[[state]] " + table.substr(6);
  return "[" + table + "]";
}

const char* KindName(Kind kind) {
  switch (kind) {
    case Kind::kAdded:
      return "added";
    case Kind::kRemoved:
      return "removed";
    case Kind::kChanged:
      break;
  }
  return "changed";
}

const char* EffectName(ChangeEffect effect) {
  switch (effect) {
    case ChangeEffect::kTakeover:
      return "takeover";
    case ChangeEffect::kRestart:
      return "restart";
    case ChangeEffect::kNewStart:
      break;
  }
  return "new_start";
}

std::string KeyLine(const ConfigChange& change, bool colour) {
  std::string line = "  " + Printable(change.key) + ": ";
  const auto with = [&](const char* sign, const std::string& text, Style style) {
    if (!text.empty()) line += Paint(sign + Printable(text), style, colour) + " ";
  };
  if (change.kind == Kind::kChanged && !change.is_set) {
    line += Printable(change.before) + " → " + Printable(change.after) + " ";
  } else {
    with("- ", change.before, Style::kBad);
    with("+ ", change.after, Style::kGood);
  }
  line.back() = '\n';
  return line;
}

std::string EffectText(const ConfigDiff& diff) {
  const std::string file = Printable(ShellWord(diff.after));
  if (diff.needs_new_start) {
    std::vector<std::string> keys;
    for (const ConfigChange& change : diff.changes) {
      if (change.effect != ChangeEffect::kNewStart) continue;
      keys.push_back(TableName(Printable(change.table)) +
                     (change.key.empty() ? "" : " " + Printable(change.key)));
    }
    return "needs a new start (" + Joined(keys) + "): `musher down`, then `musher up " + file +
           "`\n";
  }
  std::string text = "while the robot runs: `musher up --detach --takeover " + file + "`";
  for (const std::string& name : diff.restarts) text += ", `musher restart " + name + "`";
  text += '\n';
  if (!diff.left_behind.empty()) {
    const std::vector<std::string> names(diff.left_behind.begin(), diff.left_behind.end());
    text += Joined(names) + (names.size() == 1 ? " keeps" : " keep") +
            " running after that, without a controller, until the process is ended\n";
  }
  return text;
}

}  // namespace

std::string DiffText(const ConfigDiff& diff, bool colour) {
  if (diff.changes.empty()) {
    return Printable(diff.before) + " and " + Printable(diff.after) +
           " describe the same machine\n";
  }
  std::string text;
  std::string table;
  for (const ConfigChange& change : diff.changes) {
    const std::string name = TableName(Printable(change.table));
    if (change.key.empty()) {
      const bool added = change.kind == Kind::kAdded;
      text +=
          Paint((added ? "+ " : "- ") + name, added ? Style::kGood : Style::kBad, colour) + "\n";
      table = change.table;
      continue;
    }
    if (change.table != table) text += Paint(name, Style::kBold, colour) + "\n";
    table = change.table;
    text += KeyLine(change, colour);
  }
  return text + EffectText(diff);
}

std::string DiffJson(const ConfigDiff& diff) {
  OrderedJson changes = OrderedJson::array();
  for (const ConfigChange& change : diff.changes) {
    changes.push_back({{"table", change.table},
                       {"key", Known(change.key)},
                       {"change", KindName(change.kind)},
                       {"before", Known(change.before)},
                       {"after", Known(change.after)},
                       {"effect", EffectName(change.effect)}});
  }
  return JsonLine({{"same", diff.changes.empty()},
                   {"before", diff.before},
                   {"after", diff.after},
                   {"changes", changes},
                   {"needs_new_start", diff.needs_new_start},
                   {"restarts", diff.restarts},
                   {"left_behind", diff.left_behind}});
}

}  // namespace musher::cli
