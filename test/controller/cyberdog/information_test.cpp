// What an app learns from CyberDog's manager about the rest of the robot.

#include <nlohmann/json.hpp>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/controller/cyberdog/managed_robot.hpp"

namespace musher::testing {
namespace {

using Json = nlohmann::json;

class CyberdogInformation : public ManagedRobot {
 protected:
  Json About(std::vector<bool> enables) {
    const auto answer = Call<msg::DeviceInfo>("query_divice_info", {std::move(enables), "me"});
    EXPECT_EQ(answer.code, 0);
    return Json::parse(answer.info);
  }
};

TEST_F(CyberdogInformation, TheBatteryIsTheLastThatWasHeard) {
  BringUp();
  EXPECT_EQ(Call<msg::BmsInfo>("bms_info").code, 1402) << "none has come yet";
  SetBattery(64);
  auto answer = Call<msg::BmsInfo>("bms_info");
  EXPECT_EQ(answer.code, 0);
  EXPECT_EQ(answer.msg.batt_soc, 64);
  EXPECT_EQ(answer.msg.batt_volt, 29'000);
  robot_.RunFor(std::chrono::seconds(30));
  answer = Call<msg::BmsInfo>("bms_info");
  EXPECT_EQ(answer.code, 1407) << "it is old";
  EXPECT_EQ(answer.msg.batt_soc, 64);
}

TEST_F(CyberdogInformation, ErrorsOfModulesArePassedOnAsJson) {
  BringUp();
  std::vector<std::string> told;
  Hear<msg::String>("manager_errors", [&](const msg::String& text) { told.push_back(text.data); });
  const auto error = Tell<msg::NodeError>("node_errors");
  Settle();
  error({"audio", 5009});
  error({"a \"name\"\n\xff", -3});
  error({std::string(100'000, 'x'), 1});
  Settle();
  ASSERT_EQ(told.size(), 3U);
  EXPECT_EQ(told[0], R"({"name":"audio","code":5009})");
  EXPECT_EQ(Json::parse(told[1])["code"], -3);
  EXPECT_LT(told[2].size(), 1000U);
}

TEST_F(CyberdogInformation, OnlyWhatIsAskedForIsTold) {
  BringUp();
  EXPECT_EQ(About({}), Json::object());
  EXPECT_EQ(About(std::vector<bool>(15, false)), Json::object());
  std::vector<bool> charging(15, false);
  charging[14] = true;
  SetBattery(50, true);
  EXPECT_EQ(About(charging), (Json{{"charging", true}}));
}

TEST_F(CyberdogInformation, WhatIsNotKnownIsNull) {
  BringUp();
  Json all = About(std::vector<bool>(15, true));
  EXPECT_EQ(all.size(), 15U);
  for (const char* key : {"sn", "wifi", "volume", "stand", "bat_info", "charging"}) {
    EXPECT_TRUE(all[key].is_null()) << key;
  }
  EXPECT_EQ(all["lowpower_control"], false);
  EXPECT_EQ(all["device_model"], "test");
  SetBattery(50);
  all = About(std::vector<bool>(15, true));
  EXPECT_EQ(all["bat_info"]["soc"], 50);
  EXPECT_EQ(all["charging"], false);
}

TEST_F(CyberdogInformation, MoreThanThereIsToAskForIsRefused) {
  BringUp();
  const auto answer = Call<msg::DeviceInfo>("query_divice_info", {std::vector<bool>(16, true), ""});
  EXPECT_EQ(answer.code, kCodeParametersInvalid);
  EXPECT_EQ(answer.info, "");
}

}  // namespace
}  // namespace musher::testing
