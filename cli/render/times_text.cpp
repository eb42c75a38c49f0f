#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "musher/base/words.hpp"
#include "musher/cli/config/config_places.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/printable.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/times.hpp"

namespace musher::cli {
namespace {

std::string Ms(double ms) {
  return fmt::format("{:.{}f}", ms, ms < 10 ? 1 : 0);
}

Table::Cell NoteOf(const LearnedTime& row) {
  std::string note;
  const auto add = [&note](const std::string& text) { note += (note.empty() ? "" : "; ") + text; };
  if (row.proposed_ms) {
    add("propose " + Ms(*row.proposed_ms));
    if (row.beyond_proposed != 0) {
      add(Counted(row.beyond_proposed, row.Noun()) + " would have been overdue with it");
    }
    if (row.limit_ms && *row.proposed_ms < *row.limit_ms) {
      add("a hang would be seen " + Ms(*row.limit_ms - *row.proposed_ms) + " ms sooner");
    }
  }
  if (const auto share = row.ShareOfLimit(); share && *share >= 0.5) {
    add(fmt::format("{:.0f} % of the limit", 100 * *share));
  }
  if (row.missing != 0)
    add(Counted(row.missing, std::string("more ") + row.Noun()) + " needed for a limit");
  if (row.overdue_at_limit != 0) add(fmt::format("{} overdue", row.overdue_at_limit));
  if (const std::size_t before = row.overdue - row.overdue_at_limit; before != 0) {
    add(fmt::format("{} overdue{}", before, row.limit_ms ? " with a shorter limit" : ""));
  }
  if (row.drift) {
    const std::string& journal = row.drift->journal;
    add(fmt::format("takes {:.1f} times as long since {}{}", row.drift->factor,
                    LocalText(row.drift->since_wall_ns).substr(0, 16),
                    journal.empty() ? "" : " in " + Printable(journal)));
  }
  if (!row.limit_ms) add("not in the config");
  const bool worth = row.proposed_ms || row.overdue != 0 || row.drift;
  return {note, worth ? Style::kBusy : Style::kDim};
}

}  // namespace

std::string TimesText(const std::vector<LearnedTime>& rows, const MachineConfig& config,
                      bool colour) {
  if (rows.empty()) return "no command has ended in these journals\n";
  Table table(
      {"ACTUATOR", "STATE", "COMMANDS", "MEDIAN ms", "P99.9 ms", "LONGEST ms", "LIMIT ms", "NOTE"});
  for (const LearnedTime& row : rows) {
    table.Add({{Printable(row.actuator), Style::kBold},
               {Printable(row.state)},
               {std::to_string(row.commands)},
               {Ms(row.median_ms)},
               {Ms(row.p999_ms)},
               {Ms(row.longest_ms)},
               {row.limit_ms ? Ms(*row.limit_ms) : "-"},
               NoteOf(row)});
  }
  std::string text = table.Text(colour);
  const ConfigPlaces places(config.file);
  for (const ActuatorConfig& actuator : config.actuators) {
    const std::string proposed = ProposedTimes(actuator, rows);
    if (proposed.empty()) continue;
    text += fmt::format("\n{}:{}  [actuator.{}]\n", config.file,
                        places.LineOf("actuator." + actuator.name, "times"), actuator.name);
    text += Paint("-" + TimesLine(actuator), Style::kBad, colour) + '\n' +
            Paint("+" + proposed, Style::kGood, colour) + '\n';
  }
  return text;
}

std::string TimesJson(const std::vector<LearnedTime>& rows, const std::string& diff) {
  const auto or_null = [](const std::optional<double>& number) {
    return number ? OrderedJson(*number) : OrderedJson();
  };
  OrderedJson all = OrderedJson::array();
  for (const LearnedTime& row : rows) {
    OrderedJson drift;
    if (row.drift) {
      drift = {{"factor", row.drift->factor},
               {"since", UtcText(row.drift->since_wall_ns)},
               {"journal", Known(row.drift->journal)}};
    }
    all.push_back({{"actuator", row.actuator},
                   {"state", row.state},
                   {"commands", row.commands},
                   {"overdue", row.overdue},
                   {"overdue_at_limit", row.overdue_at_limit},
                   {"median_ms", row.median_ms},
                   {"p999_ms", row.p999_ms},
                   {"longest_ms", row.longest_ms},
                   {"limit_ms", or_null(row.limit_ms)},
                   {"limit_share", or_null(row.ShareOfLimit())},
                   {"proposed_ms", or_null(row.proposed_ms)},
                   {"beyond_proposed", row.beyond_proposed},
                   {"missing_commands", row.missing},
                   {"drift", drift}});
  }
  return JsonLine({{"times", all}, {"diff", Known(diff)}});
}

}  // namespace musher::cli
