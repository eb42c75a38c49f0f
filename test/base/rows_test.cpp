#include "musher/base/toml/rows.hpp"

#include <gmock/gmock.h>

#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/file.hpp"

namespace musher::rows_test {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using ::testing::ElementsAre;

enum class Colour { kRed, kBlue };

struct Lamp {
  int watts = 5;
  double share = 0.5;
  double turned_rad = 0.25;
  Duration wait = Milliseconds(100);
  bool on = true;
  std::string name = "lamp";
  std::string file = "/etc/lamp.png";
  std::string topic = "lamp/state";
  std::string light_switch = "switch_lamp";
  std::vector<std::string> dimmer;
  double x_m = 1;
  double y_m = 2;
  Colour colour = Colour::kRed;
  int least = 1;
  int most = 9;
};

struct Reading {
  std::optional<Lamp> lamp;
  std::vector<Diagnostic> diagnostics;
};

Reading Read(std::string_view text) {
  return config_toml::ReadTextWith<Reading>(
      text, "lamp.toml", [](const Table& table, Findings& findings) {
        Lamp lamp;
        TableReader root(table, {1, 1}, "", findings);
        ReadRows(root, {row::Integer("watts", lamp.watts, 0, 100, " (watts)"),
                        row::Number("share", lamp.share, 0, 1),
                        row::Degrees("turned_deg", lamp.turned_rad, -180, 180),
                        row::Time("wait_ms", lamp.wait, 10), row::Bool("on", lamp.on),
                        row::Text("name", lamp.name), row::File("file", lamp.file, "/etc"),
                        row::Topic("topic", lamp.topic, "lamp/state"),
                        row::Topic("switch", lamp.light_switch, "switch_lamp",
                                   {.of = "a service", .relative = true, .may_be_empty = true}),
                        row::Program("dimmer", lamp.dimmer, "/opt"),
                        row::Numbers("at_m", {&lamp.x_m, &lamp.y_m}, -5, 5,
                                     "expected [x, y] in metres, each -5 to 5"),
                        row::Choice("colour", lamp.colour,
                                    {{"red", Colour::kRed}, {"blue", Colour::kBlue}}),
                        row::Sub("range", {row::Required("least", "a number of lamps",
                                                         row::Integer("least", lamp.least, 0, 10)),
                                           row::Integer("most", lamp.most, 0, 10),
                                           row::Check(
                                               "most", [&] { return lamp.least <= lamp.most; },
                                               "must not be less than least")})});
        return lamp;
      });
}

std::vector<std::string> ErrorsOf(std::string_view text) {
  std::vector<std::string> lines;
  for (const Diagnostic& diagnostic : Read(text).diagnostics) {
    lines.push_back(FormatDiagnostic(diagnostic));
  }
  return lines;
}

TEST(Rows, GiveTheValuesOfTheFile) {
  const Reading reading = Read(R"(
watts = 40
share = 1
turned_deg = 90
wait_ms = 20
on = false
name = "torch"
file = "torch.png"
topic = "/torch"
dimmer = ["bin/dim", "50", "50"]
at_m = [4, -0.5]
colour = "blue"
[range]
least = 2
most = 3
)");
  ASSERT_TRUE(reading.lamp);
  EXPECT_EQ(reading.lamp->watts, 40);
  EXPECT_EQ(reading.lamp->share, 1);
  EXPECT_DOUBLE_EQ(reading.lamp->turned_rad, std::numbers::pi / 2);
  EXPECT_EQ(reading.lamp->wait, Milliseconds(20));
  EXPECT_FALSE(reading.lamp->on);
  EXPECT_EQ(reading.lamp->name, "torch");
  EXPECT_EQ(reading.lamp->file, "/etc/torch.png");
  EXPECT_EQ(reading.lamp->topic, "/torch");
  EXPECT_THAT(reading.lamp->dimmer, ElementsAre("/opt/bin/dim", "50", "50"));
  EXPECT_EQ(reading.lamp->x_m, 4);
  EXPECT_EQ(reading.lamp->y_m, -0.5);
  EXPECT_EQ(reading.lamp->colour, Colour::kBlue);
  EXPECT_EQ(reading.lamp->least, 2);
  EXPECT_EQ(reading.lamp->most, 3);
}

TEST(Rows, KeepWhatTheFileDoesNotHave) {
  const Reading reading = Read("");
  ASSERT_TRUE(reading.lamp);
  EXPECT_EQ(reading.lamp->watts, 5);
  EXPECT_EQ(reading.lamp->turned_rad, 0.25);
  EXPECT_EQ(reading.lamp->file, "/etc/lamp.png");
  EXPECT_EQ(reading.lamp->most, 9) << "a table that is missing has no check";
}

TEST(Rows, ReportEachWrongValueWithItsLine) {
  EXPECT_THAT(
      ErrorsOf("watts = 101\nturned_deg = 200\nwait_ms = 5\ntopic = \"1\"\n"
               "colour = \"bleu\"\n"),
      ElementsAre(
          "lamp.toml:1:9: error: watts: expected an integer from 0 to 100 (watts), found 101",
          "lamp.toml:2:14: error: turned_deg: expected a number from -180 to 180, found 200",
          "lamp.toml:3:11: error: wait_ms: expected an integer from 10 to 3600000 "
          "(milliseconds), found 5",
          "lamp.toml:4:9: error: topic: expected the name of a topic, as in \"lamp/state\", found "
          "\"1\"",
          "lamp.toml:5:10: error: colour: expected one of red and blue, found \"bleu\"; did you "
          "mean \"blue\"?"));
}

TEST(Rows, HaveTopicsServicesAndActionsByOneRule) {
  EXPECT_EQ(Read("switch = \"\"\n").lamp->light_switch, "");
  EXPECT_EQ(Read("topic = \"/lamp/state\"\n").lamp->topic, "/lamp/state");
  EXPECT_THAT(
      ErrorsOf("topic = \"\"\nswitch = \"/switch_lamp\"\n"),
      ElementsAre("lamp.toml:1:9: error: topic: expected the name of a topic, as in "
                  "\"lamp/state\", found \"\"",
                  "lamp.toml:2:10: error: switch: expected the name of a service relative to the "
                  "namespace, as in \"switch_lamp\", or \"\" for none, found \"/switch_lamp\""));
}

TEST(Rows, ReportTheFirstOfSeveralNumbersThatIsWrongAndAListOfAnotherSize) {
  const std::string expected = "error: at_m: expected [x, y] in metres, each -5 to 5";
  for (const auto& [value, column] : {std::pair("[1, 6]", "12"),
                                      {"[nan, 1]", "9"},
                                      {"[\"1\", 1]", "9"},
                                      {"[1]", "8"},
                                      {"3", "8"}}) {
    EXPECT_THAT(ErrorsOf(std::string("at_m = ") + value),
                ElementsAre("lamp.toml:1:" + std::string(column) + ": " + expected));
  }
}

TEST(Rows, ReportAProgramWithoutAName) {
  EXPECT_THAT(ErrorsOf("dimmer = [\"\"]"),
              ElementsAre("lamp.toml:1:11: error: dimmer: expected a program, found an empty "
                          "string"));
  EXPECT_THAT(ErrorsOf("dimmer = []"),
              ElementsAre("lamp.toml:1:10: error: dimmer: expected at least one string, found an "
                          "empty array"));
}

TEST(Rows, ReportKeysThatNoneOfThemHas) {
  EXPECT_THAT(ErrorsOf("[range]\nleast = 1\nmots = 2\n"),
              ElementsAre("lamp.toml:3:1: error: range: unknown key \"mots\"; did you mean "
                          "\"most\"?"));
}

TEST(Rows, ReportAKeyThatIsRequiredAndATableThatContradictsItself) {
  EXPECT_THAT(ErrorsOf("[range]\nmost = 0\n"),
              ElementsAre("lamp.toml:1:1: error: range: the key \"least\" is missing; expected a "
                          "number of lamps",
                          "lamp.toml:2:8: error: range.most: must not be less than least"));
}

}  // namespace musher::rows_test
