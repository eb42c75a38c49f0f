// The exact documents of --json: programs depend on them.

#include "musher/cli/render/json.hpp"
#include "musher/cli/console/error_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/test/cli/robot.hpp"

namespace musher::cli::json_test {

TEST(Json, HasTheStatusOfAMachine) {
  StatusSince since;
  since.units = {{"legs", "musher-dog-legs.service"}};
  EXPECT_EQ(
      StatusJson(RobotStatus(), {}, since),
      R"({"machine":"dog","pid":100,"state":"Active","degraded":["eyes"],"actuators":{)"
      R"("legs":{"state":"Active","pid":101,"target":"LowPower","presence":"present","stage":1,)"
      R"("critical":true,"held":false,"degraded":false,"code":0,"message":"","host":"here",)"
      R"("health":"well","restarts":0,"restarting":false,"unit":"musher-dog-legs.service"},)"
      R"("eyes":{"state":"SetUp","pid":null,"target":null,"presence":"lost","stage":2,"critical":false,)"
      R"("held":true,"degraded":true,"code":107,"message":"gone\n","host":"here",)"
      R"("health":"crashed","restarts":2,"restarting":true,"unit":null}},)"
      R"("unlisted":{},"phase":"running","target":"LowPower","epoch":3,"switch":12,"namespace":"pack",)"
      R"("config":"dog.toml","config_hash":"cafe","host":"here",)"
      R"("emergency_stop":{"engaged":false,"by":null,"reason":""},"held_by_stop":[],"not_on_disk":[],"policy":null,)"
      R"("machine_id":null,"other_machines":[],"other_vendors":[],"requested_by":null,"since":null,"uptime_s":null,"violated_rules":[],"not_stopped":[],"hosts":null,"standby":null})");
}

TEST(Json, HasTheStandbyOfThisHost) {
  StatusSince since;
  since.standby = {{"dog", "id-1"}, "a controller leads", 7};
  const std::string standby =
      R"("standby":{"machine":"dog","machine_id":"id-1","pid":7,"why_not_leading":"a controller leads"}})";
  EXPECT_THAT(StatusJson(RobotStatus(), {}, since), ::testing::HasSubstr(standby));
  const Failure failure{ExitCode::kNoController, {kCodeNetError, "no controller"}};
  EXPECT_THAT(RunningJson(failure, {}, since.standby), ::testing::HasSubstr(standby));
}

TEST(Json, HasAnEmergencyStopAndItsRelease) {
  msg::MachineStatus status = RobotStatus();
  EXPECT_EQ(
      ReleaseJson(status, {"00000000000000a1"}),
      R"({"engaged":false,"machine":"dog","state":"Active","phase":"running","released":["00000000000000a1"]})");
  status.emergency_stop = true;
  status.emergency_stop_by = "alice";
  status.emergency_stop_reason = "smoke";
  EXPECT_NE(
      StatusJson(status).find(R"("emergency_stop":{"engaged":true,"by":"alice","reason":"smoke"})"),
      std::string::npos);
}

TEST(Json, ListsWhatIsNotOnDiskYet) {
  msg::MachineStatus status = RobotStatus();
  status.not_on_disk = {"emergency stop (4 s)"};
  EXPECT_NE(StatusJson(status).find(R"x("not_on_disk":["emergency stop (4 s)"])x"),
            std::string::npos);
}

TEST(Json, HasThePolicyAndAnUnknownBattery) {
  msg::MachineStatus status = RobotStatus();
  status.policy.active = true;
  EXPECT_NE(StatusJson(status).find(R"("policy":{"battery":null,"charging":false,)"),
            std::string::npos);
  status.policy.battery = 15;
  status.policy.ceiling = "Protected";
  status.policy.kept = "Active";
  status.policy.keep_s = 60;
  status.policy.power = "reboot";
  EXPECT_NE(StatusJson(status).find(
                R"("policy":{"battery":15,"charging":false,"battery_silent":false,)"
                R"("ceiling":"Protected","ceiling_reason":"","kept":"Active","keep_s":60,)"
                R"("low_power_switch":false,"power":"reboot"})"),
            std::string::npos);
}

TEST(Json, HasARestartedActuatorWithItsNameAndAllKeys) {
  EXPECT_EQ(RestartJson(RobotStatus().actuators[0]),
            R"({"actuator":"legs","state":"Active","pid":101,"target":"LowPower",)"
            R"("presence":"present","stage":1,"critical":true,"held":false,"degraded":false,)"
            R"("code":0,"message":"","host":"here","health":"well","restarts":0,)"
            R"("restarting":false})");
}

TEST(Json, HasTheSameKeysForAMachineWithoutActuators) {
  msg::MachineStatus status;
  EXPECT_NE(StatusJson(status).find(R"("degraded":[],"actuators":{})"), std::string::npos);
}

TEST(Json, HasTheOutcomeOfASwitch) {
  msg::SetState::Response result{12,
                                 "LowPower",
                                 "",
                                 "done-degraded",
                                 107,
                                 "eyes: …",
                                 "Active",
                                 {"eyes"},
                                 {{"eyes", "lost", 107, "silent", 1.5, "SetUp"}}};
  EXPECT_EQ(SwitchJson(result),
            R"({"switch":12,"target":"LowPower","actuator":null,"outcome":"done-degraded",)"
            R"("code":107,"reason":"eyes: …","state":"Active","degraded":["eyes"],"actuators":{)"
            R"("eyes":{"outcome":"lost","code":107,"message":"silent","duration_ms":1.5,)"
            R"("state":"SetUp"}}})");
}

TEST(Json, HasTheSameKeysForARefusal) {
  msg::SetState::Response refusal;
  refusal.target = "Actve";
  refusal.outcome = "refused";
  refusal.code = 110;
  refusal.reason = "unknown state";
  refusal.state = "Active";
  EXPECT_EQ(SwitchJson(refusal),
            R"({"switch":null,"target":"Actve","actuator":null,"outcome":"refused","code":110,)"
            R"("reason":"unknown state","state":"Active","degraded":[],"actuators":{}})");
}

TEST(Json, HasAPlan) {
  msg::GetPlan::Response plan{
      "LowPower", "", true, 0, "", "down", "Active", {{"legs", 1, "Active", "LowPower", 5, ""}}};
  EXPECT_EQ(PlanJson(plan),
            R"({"target":"LowPower","actuator":null,"allowed":true,"code":0,"reason":"",)"
            R"("direction":"down","state":"Active","steps":[{"actuator":"legs","wave":1,)"
            R"("from":"Active","to":"LowPower","deadline_ms":5,"note":""}]})");
}

TEST(Json, HasTheCapabilities) {
  const msg::Capability flip{"flip",   "backwards", false, 113, "runs in Active only",
                             {"legs"}, {"Active"}};
  const std::string one =
      R"({"capability":"flip","description":"backwards","allowed":false,"code":113,)"
      R"("reason":"runs in Active only","uses":["legs"],"states":["Active"]})";
  EXPECT_EQ(CapabilityJson(flip), one);
  EXPECT_EQ(CapabilitiesJson({{flip, flip}}), R"({"capabilities":[)" + one + "," + one + "]}");
  EXPECT_EQ(CapabilitiesJson({}), R"({"capabilities":[]})");
}

TEST(Json, HasAHistory) {
  EXPECT_EQ(
      HistoryJson(
          {"", {{9, 1'500'000'000, 3, 12, "switch", "", 0, "done", 7, "Active"}}, {"switch_done"}}),
      R"({"entries":[{"time":"1970-01-01T00:00:01.500Z","epoch":3,"switch":12,)"
      R"("kind":"switch","event":"switch_done","actuator":null,"code":0,"message":"done",)"
      R"("id":9,"cause":7,)"
      R"("new_state":"Active","data":null,"arguments":{}}],"damage":null})");
  EXPECT_THAT(HistoryJson({"", {{9, 1, 3, 12, "switch", "", 0, "done", 7, ""}}, {}}),
              ::testing::HasSubstr(R"("event":null)"))
      << "of a controller that sends no events";
  const std::string data = R"({"arguments":{"pid":12,"actuator":"legs"}})";
  EXPECT_THAT(HistoryJson({"", {{9, 1, 3, 12, "process", "", 0, "started", 7, "", data}}, {}}),
              ::testing::HasSubstr(R"("arguments":{"pid":12,"actuator":"legs"})"));
  for (const char* other : {"#0 in main", "{", "[1]", R"({"arguments":7})"}) {
    EXPECT_THAT(HistoryJson({"", {{9, 1, 3, 12, "process", "", 0, "hung", 7, "", other}}, {}}),
                ::testing::HasSubstr(R"("arguments":{})"))
        << other;
  }
  EXPECT_EQ(HistoryJson({"torn", {}}), R"({"entries":[],"damage":"torn"})");
}

TEST(Json, HasNoJsonInTexts) {
  const auto entry_with = [](const std::string& data) {
    return HistoryJson({"", {{9, 1, 3, 12, "switch", "", 0, "done", 7, "", data}}, {}});
  };
  EXPECT_THAT(entry_with(R"({"target":"Active","outcome":"done","arguments":{"pid":12}})"),
              ::testing::HasSubstr(R"("data":{"target":"Active","outcome":"done"},"arguments":)"
                                   R"({"pid":12})"));
  EXPECT_THAT(entry_with(R"({"arguments":{"pid":12}})"), ::testing::HasSubstr(R"("data":null)"));
  EXPECT_THAT(entry_with("#0 in main"), ::testing::HasSubstr(R"("data":"#0 in main")"));
}

TEST(Json, HasDiagnostics) {
  const Diagnostic warning{"dog.toml", 2, 7, Severity::kWarning, "hm"};
  EXPECT_EQ(CheckJson({}), R"({"valid":true,"diagnostics":[]})");
  EXPECT_EQ(CheckJson({warning}),
            R"({"valid":true,"diagnostics":[{"file":"dog.toml","line":2,"column":7,)"
            R"("severity":"warning","message":"hm"}]})");
  EXPECT_EQ(CheckJson({{"dog.toml", 0, 0, Severity::kError, "no"}}),
            R"({"valid":false,"diagnostics":[{"file":"dog.toml","line":null,"column":null,)"
            R"("severity":"error","message":"no"}]})");
}

TEST(Json, HasTheEventsOfUp) {
  EXPECT_EQ(ProgressJson({2'000'000'000, "process", "legs", 0, 0, "started"}),
            R"({"time":"1970-01-01T00:00:02.000Z","kind":"process","actuator":"legs",)"
            R"("switch":null,"code":0,"message":"started"})");
}

TEST(Json, StaysJsonWhateverBytesAMessageHas) {
  EXPECT_EQ(FailureJson({ExitCode::kNotDone, {101, "bad \xff \"byte\"\n"}}),
            "{\"error\":\"bad \xEF\xBF\xBD \\\"byte\\\"\\n\",\"code\":101,"
            "\"switch\":null,\"diagnostics\":[]}");
}

}  // namespace musher::cli::json_test
