#include "musher/modules/meilin/plan/planner_config.hpp"

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::meilin {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

void SetTopicName(TableReader& reader, std::string_view key, std::string& value) {
  const auto topic = reader.String(key);
  if (!topic) return;
  if (!config_toml::IsTopic(topic->text)) {
    reader.Fault(topic->at, key, "expected the name of a topic, as in \"mf_r2_data\"");
  }
  value = topic->text;
}

void SetSeconds(TableReader& reader, std::string_view key, double& value) {
  value = reader.Number(key, 0, 1000).value_or(value);
}

void ReadTopics(TableReader& reader, PlannerTopics& topics) {
  SetTopicName(reader, "map", topics.map);
  SetTopicName(reader, "paths", topics.paths);
  SetTopicName(reader, "plan", topics.plan);
  SetTopicName(reader, "command", topics.command);
  SetTopicName(reader, "last_error", topics.last_error);
  SetTopicName(reader, "buffer_status", topics.buffer_status);
  SetTopicName(reader, "buffer_service", topics.buffer_service);
  reader.RefuseOthers();
}

void ReadCosts(TableReader& reader, StepCosts& costs) {
  SetSeconds(reader, "flat_s", costs.flat_s);
  SetSeconds(reader, "up_200_s", costs.up_200_s);
  SetSeconds(reader, "up_400_s", costs.up_400_s);
  SetSeconds(reader, "down_200_s", costs.down_200_s);
  SetSeconds(reader, "down_400_s", costs.down_400_s);
  SetSeconds(reader, "fetch_s", costs.fetch_s);
  SetSeconds(reader, "fetch_turn_s", costs.fetch_turn_s);
  reader.RefuseOthers();
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
  TableReader root(table, {1, 1}, "", findings);
  RouteRules& rules = config.rules;
  config.auto_send = root.Time("auto_send_ms", 0).value_or(config.auto_send);
  if (const auto most = root.Integer("most_routes", 1, 100)) {
    rules.most_routes = static_cast<std::size_t>(*most);
  }
  rules.plan.normal_height_mm =
      root.Number("normal_height_mm", 0, 1000).value_or(rules.plan.normal_height_mm);
  rules.plan.highest_wheel_mm =
      root.Number("highest_wheel_mm", 0, 1000).value_or(rules.plan.highest_wheel_mm);
  rules.plan.kfs1_blocks = root.Bool("kfs1_blocks").value_or(rules.plan.kfs1_blocks);
  ReadEntrance(root, rules.entrance);
  if (const Table* topics = root.SubTable("topics")) {
    TableReader reader(*topics, root.At("topics"), "topics", findings);
    ReadTopics(reader, config.topics);
  }
  if (const Table* costs = root.SubTable("costs")) {
    TableReader reader(*costs, root.At("costs"), "costs", findings);
    ReadCosts(reader, rules.costs);
  }
  root.RefuseOthers();
  return config;
}

}  // namespace

PlannerReading ReadPlannerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<PlannerReading>(text, path, ReadPlanner);
}

PlannerReading ReadPlannerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadPlannerText);
}

}  // namespace musher::meilin
