#include "musher/modules/race/course_parts.hpp"

#include <algorithm>

#include "musher/base/suggest.hpp"

namespace musher::race::parts {

std::optional<Index> Refer(TableReader& table, std::string_view key, std::string_view kind,
                           const config_toml::Word& word, const std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, word.text);
  if (found != names.end()) return static_cast<Index>(found - names.begin());
  table.Fault(word.at, key, NoSuch(kind, word.text, names));
  return std::nullopt;
}

std::vector<Index> States(TableReader& table, std::string_view key, Reading& reading) {
  std::vector<Index> states;
  const auto words = table.Strings(key);
  if (!words) return states;
  const std::vector<std::string> names = NamesOf(reading.course.states);
  for (const auto& word : *words) {
    const auto state = Refer(table, key, "state", word, names);
    if (state) states.push_back(*state);
    if (!state) reading.has_leads = false;
  }
  return states;
}

std::optional<int> Count(TableReader& table, std::string_view key) {
  const auto count = table.Integer(key, 1, kMostSteps, " steps");
  if (!count) return std::nullopt;
  return static_cast<int>(*count);
}

std::optional<Stretch> ReadStretch(TableReader& table, const Reading& reading,
                                   std::string_view count) {
  table.Require("move", "the name of a movement");
  const auto movement = Reference(table, "move", "movement", reading.course.movements);
  const auto steps = Count(table, count);
  if (!movement) return std::nullopt;
  const Movement& moved = reading.course.movements[*movement];
  if (!moved.walks) {
    table.Fault(table.At("move"), "move",
                moved.name + " is one motion; expected a movement with a twist, which has steps");
    return std::nullopt;
  }
  if (!steps && table.Has(count)) return std::nullopt;
  return Stretch{*movement, steps.value_or(moved.count)};
}

std::optional<Stretch> StretchAt(TableReader& table, std::string_view key, Reading& reading) {
  const Table* stretch = table.SubTable(key);
  if (stretch == nullptr) return std::nullopt;
  TableReader reader(*stretch, table.At(key), table.path() + "." + std::string(key),
                     reading.findings);
  const auto read = ReadStretch(reader, reading);
  reader.RefuseOthers();
  return read;
}

Row CounterRow(std::string_view key, const Reading& reading, std::optional<Index>& counter) {
  return [key, &reading, &counter](TableReader& table) {
    const auto word = table.String(key);
    if (word) counter = Refer(table, key, "counter", *word, reading.course.counters);
  };
}

Row StatesRow(std::string_view key, Reading& reading, std::vector<Index>& states) {
  return [key, &reading, &states](TableReader& table) { states = States(table, key, reading); };
}

Row OtherwiseRow(Otherwise& otherwise, Reading& reading) {
  return [&](TableReader& table) {
    const auto word = table.String("otherwise");
    if (!word) return;
    if (word->text == "continue") {
      otherwise = {};
    } else if (word->text == "default") {
      otherwise.kind = Otherwise::Kind::kDefault;
    } else {
      std::vector<std::string> names = NamesOf(reading.course.states);
      const auto state = Refer(table, "otherwise", "state", *word, names);
      if (state) otherwise = {Otherwise::Kind::kState, *state};
      if (!state) reading.has_leads = false;
    }
  };
}

}  // namespace musher::race::parts
