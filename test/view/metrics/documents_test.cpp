// The dashboard, the alerts and the page about them name what /metrics has.

#include <gmock/gmock.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "musher/test/support/paths.hpp"
#include "musher/test/view/metrics/openmetrics_grammar.hpp"
#include "musher/view/metrics/robot_metrics.hpp"

namespace musher::view::documents_test {

using ::testing::IsSupersetOf;
using Json = nlohmann::json;
using Names = std::set<std::string>;

std::string Read(const std::string& path) {
  std::ifstream file(SourceDir() + "/docs/" + path);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_FALSE(text.empty()) << path;
  return text;
}

// Without label names: those of statesets are names of metrics as well.
Names MetricsIn(const std::string& text) {
  static const std::regex name("musher_[a-z0-9_]+");
  return {std::sregex_token_iterator(text.begin(), text.end(), name), {}};
}

musher::testing::ParsedMetrics Written() {
  return musher::testing::ParseOpenMetrics(
      RobotMetrics().Text(Time{}, MetricsFormat::kOpenMetrics));
}

// The names of samples that a query can have, label names included.
Names Queryable() {
  Names names;
  for (const auto& family : Written().families) {
    const std::string& type = family.type;
    if (type == "histogram") {
      for (const char* suffix : {"_bucket", "_sum", "_count"}) names.insert(family.name + suffix);
    } else {
      names.insert(family.name + (type == "counter" ? "_total" : type == "info" ? "_info" : ""));
    }
  }
  return names;
}

std::vector<Json> Panels() {
  const Json board = Json::parse(Read("grafana/musher.json"));
  std::vector<Json> panels;
  for (const Json& panel : board["panels"]) {
    if (panel["type"] != "row") panels.push_back(panel);
  }
  return panels;
}

TEST(Dashboard, EveryQueryIsAboutMetricsThatExist) {
  const Names queryable = Queryable();
  Names queried;
  for (const Json& panel : Panels()) {
    for (const Json& target : panel["targets"]) {
      const std::string query = target["expr"];
      const Names names = MetricsIn(query);
      EXPECT_THAT(queryable, IsSupersetOf(names)) << query;
      queried.insert(names.begin(), names.end());
    }
  }
  EXPECT_GT(queried.size(), 15U);
  const Json board = Json::parse(Read("grafana/musher.json"));
  for (const Json& variable : board["templating"]["list"]) {
    if (variable["type"] == "datasource") continue;
    EXPECT_THAT(queryable, IsSupersetOf(MetricsIn(variable["definition"]))) << variable;
  }
}

TEST(Dashboard, HasVariablesForRobotAndActuator) {
  Names names;
  const Json board = Json::parse(Read("grafana/musher.json"));
  for (const Json& variable : board["templating"]["list"]) {
    names.insert(variable["name"].get<std::string>());
  }
  EXPECT_EQ(names, (Names{"actuator", "datasource", "robot"}));
}

TEST(Dashboard, EveryPanelHasADescriptionAUnitAndAPlaceOfItsOwn) {
  std::set<int> ids;
  std::set<std::pair<int, int>> cells;
  for (const Json& panel : Panels()) {
    const std::string title = panel["title"];
    EXPECT_NE(panel.value("description", ""), "") << title;
    EXPECT_NE(panel["fieldConfig"]["defaults"].value("unit", ""), "") << title;
    EXPECT_TRUE(ids.insert(panel["id"].get<int>()).second) << title;
    const Json& place = panel["gridPos"];
    EXPECT_LE(place["x"].get<int>() + place["w"].get<int>(), 24) << title;
    for (int x = place["x"]; x < place["x"].get<int>() + place["w"].get<int>(); ++x) {
      for (int y = place["y"]; y < place["y"].get<int>() + place["h"].get<int>(); ++y) {
        EXPECT_TRUE(cells.insert({x, y}).second) << title << " covers another panel";
      }
    }
  }
}

// The alerts of the file, each as the text of its keys.
std::vector<std::string> Alerts() {
  const std::string text = Read("grafana/alerts.yml");
  std::vector<std::string> alerts;
  const std::string begin = "\n      - alert: ";
  for (auto at = text.find(begin); at != std::string::npos;) {
    const auto next = text.find(begin, at + 1);
    alerts.push_back(text.substr(at, next - at));
    at = next;
  }
  return alerts;
}

TEST(Alerts, EachHasAQuerySeverityAndWords) {
  Names names;
  for (const std::string& alert : Alerts()) {
    static const std::regex form(
        "\n      - alert: ([A-Z][A-Za-z]+)\n        expr: [^\n]+(\n          [^\n]+)*\n"
        "(        for: [0-9]+[sm]\n)?        labels:\n          severity: (warning|critical)\n"
        "        annotations:\n          summary: \"\\{\\{ \\$labels.instance \\}\\}: [^\n\"]+\"\n"
        "          description: \"[^\n\"]+\"\n*");
    std::smatch match;
    ASSERT_TRUE(std::regex_match(alert, match, form)) << alert;
    EXPECT_TRUE(names.insert(match[1]).second) << match[1];
  }
  EXPECT_THAT(names, IsSupersetOf({"MachineInError", "EmergencyStop", "ActuatorDegraded",
                                   "ActuatorCrashLoop", "HeartbeatLate", "SwitchSlow", "BatteryLow",
                                   "RobotNotScraped"}));
}

TEST(Alerts, EveryQueryIsAboutMetricsThatExist) {
  for (const std::string& alert : Alerts()) {
    EXPECT_THAT(Queryable(), IsSupersetOf(MetricsIn(alert))) << alert;
  }
}

// Values of a label that a query compares with: '…verdict="crashed"'.
TEST(Alerts, NameStatesAndHealthsThatExist) {
  RobotMetrics metrics;
  msg::MachineStatus status;
  status.actuators.resize(1);
  metrics.On(status, Time{});
  const std::string text = metrics.Text(Time{}, MetricsFormat::kOpenMetrics);
  for (const char* pair : {"musher_machine_state=\"Error\"", "musher_machine_phase=\"failed\"",
                           "musher_actuator_health=\"starved\"", "musher_actuator_health=\"hung\"",
                           "musher_actuator_health=\"partitioned\"", "outcome=\"undone\"",
                           "outcome=\"done-degraded\""}) {
    EXPECT_NE(text.find(pair), std::string::npos) << pair;
  }
  const std::string alerts = Read("grafana/alerts.yml");
  EXPECT_NE(alerts.find("musher_actuator_health=~\"starved|hung|partitioned\""), std::string::npos);
  EXPECT_NE(alerts.find("outcome=~\"undone|done-degraded\""), std::string::npos);
}

TEST(PageAboutManyRobots, ExplainsEveryFamilyAndNoOther) {
  Names written;
  for (const auto& family : Written().families) written.insert(family.name);
  std::string table;
  const std::string page = Read("many-robots.md");
  static const std::regex row("\n\\| (`musher_[^|]+)\\|");
  for (std::sregex_iterator at(page.begin(), page.end(), row), end; at != end; ++at) {
    table += (*at)[1];
  }
  EXPECT_EQ(MetricsIn(table), written);
}

}  // namespace musher::view::documents_test
