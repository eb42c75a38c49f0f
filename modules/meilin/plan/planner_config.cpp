#include "musher/modules/meilin/plan/planner_config.hpp"

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::meilin {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::string_view kTopic = "mf_r2_data";

Rows TopicRows(PlannerTopics& topics) {
  return {
      row::Topic("map", topics.map, kTopic),
      row::Topic("paths", topics.paths, kTopic),
      row::Topic("plan", topics.plan, kTopic),
      row::Topic("command", topics.command, kTopic),
      row::Topic("last_error", topics.last_error, kTopic),
      row::Topic("buffer_status", topics.buffer_status, kTopic),
      row::Topic("buffer_service", topics.buffer_service, kTopic),
  };
}

Row Seconds(std::string_view key, double& value_s) {
  return row::Number(key, value_s, 0, 1000);
}

Rows CostRows(StepCosts& costs) {
  return {
      Seconds("flat_s", costs.flat_s),
      Seconds("up_200_s", costs.up_200_s),
      Seconds("up_400_s", costs.up_400_s),
      Seconds("down_200_s", costs.down_200_s),
      Seconds("down_400_s", costs.down_400_s),
      Seconds("fetch_s", costs.fetch_s),
      Seconds("fetch_turn_s", costs.fetch_turn_s),
  };
}

void ReadEntrance(TableReader& root, Cell& entrance) {
  constexpr const char* kKey = "entrance";
  const auto cell = root.Integers(kKey, 0, kRows - 1);
  if (!cell) return;
  if (cell->size() == 2) entrance = {static_cast<int>(cell->at(0)), static_cast<int>(cell->at(1))};
  if (cell->size() == 2 && entrance.row == 0 && IsInside(entrance)) return;
  root.Fault(root.At(kKey), kKey,
             "expected [0, column] with a column of 0 to 2: a match enters in row 0");
}

PlannerConfig ReadPlanner(const Table& table, Findings& findings) {
  PlannerConfig config;
  RouteRules& rules = config.rules;
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root, {row::Time("auto_send_ms", config.auto_send, 0),
                  row::Integer("most_routes", rules.most_routes, 1, 100),
                  row::Number("normal_height_mm", rules.plan.normal_height_mm, 0, 1000),
                  row::Number("highest_wheel_mm", rules.plan.highest_wheel_mm, 0, 1000),
                  row::Bool("kfs1_blocks", rules.plan.kfs1_blocks),
                  [&](TableReader& reader) { ReadEntrance(reader, rules.entrance); },
                  row::Sub("topics", TopicRows(config.topics)),
                  row::Sub("costs", CostRows(rules.costs))});
  return config;
}

}  // namespace

Parsed<PlannerConfig> ReadPlannerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<PlannerConfig>>(text, path, ReadPlanner);
}

Parsed<PlannerConfig> ReadPlannerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadPlannerText);
}

}  // namespace musher::meilin
