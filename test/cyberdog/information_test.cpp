// What an app learns from CyberDog's manager about the rest of the robot.

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "musher/cyberdog/serial_number.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/cyberdog/managed_robot.hpp"

namespace musher::testing::information_test {

using Json = nlohmann::json;

class CyberdogInformation : public ManagedRobot {
 protected:
  Json About(std::vector<bool> enables) {
    const auto answer = Call<msg::DeviceInfo>("query_divice_info", {std::move(enables), "me"});
    EXPECT_EQ(answer.code, 0);
    return Json::parse(answer.info);
  }
};

TEST_F(CyberdogInformation, TheBatteryIsTheLastReceivedSample) {
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
  std::vector<std::string> received;
  Subscribe<msg::String>("manager_errors",
                         [&](const msg::String& text) { received.push_back(text.data); });
  const auto error = PublishFunction<msg::NodeError>("node_errors");
  Settle();
  error({"audio", 5009});
  error({"a \"name\"\n\xff", -3});
  error({std::string(100'000, 'x'), 1});
  Settle();
  ASSERT_EQ(received.size(), 3U);
  EXPECT_EQ(received[0], R"({"name":"audio","code":5009})");
  EXPECT_EQ(Json::parse(received[1])["code"], -3);
  EXPECT_LT(received[2].size(), 1000U);
}

TEST_F(CyberdogInformation, OnlyRequestedFieldsAreAnswered) {
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
  for (const char* key : {"uid", "wifi", "volume", "stand", "bat_info", "charging"}) {
    EXPECT_TRUE(all[key].is_null()) << key;
  }
  EXPECT_EQ(all["lowpower_control"], false);
  EXPECT_EQ(all["device_model"], "test");
  SetBattery(50);
  all = About(std::vector<bool>(15, true));
  EXPECT_EQ(all["bat_info"]["soc"], 50);
  EXPECT_EQ(all["charging"], false);
}

TEST_F(CyberdogInformation, TheSerialNumberAndTheAccountAreAnsweredAndPublished) {
  std::vector<std::string> received;
  Subscribe<msg::String>("dog_sn", [&](const msg::String& text) { received.push_back(text.data); });
  BringUp();
  robot_.RunFor(std::chrono::seconds(70));
  EXPECT_NEAR(static_cast<double>(received.size()), 600, 20) << "for a minute";
  EXPECT_EQ(received[0], "SIMULATED-1");
  EXPECT_EQ(Trigger("get_dog_sn").message, "SIMULATED-1");
  EXPECT_EQ(Call<msg::UidSn>("uid_sn"), (msg::UidSn::Response{"", "SIMULATED-1", 0}));
  const auto set_uid = PublishFunction<msg::String>("uid_set");
  Settle();
  set_uid({"account 7"});
  Settle();
  EXPECT_EQ(Call<msg::UidSn>("uid_sn"), (msg::UidSn::Response{"account 7", "SIMULATED-1", 0}));
  const Json all = About(std::vector<bool>(15, true));
  EXPECT_EQ(all["sn"], "SIMULATED-1");
  EXPECT_EQ(all["uid"], "account 7");
}

TEST_F(CyberdogInformation, TheSelfCheckOfTheStartIsInAFile) {
  BringUp();
  const auto& files = robot_.disk(0).files;
  robot_.RunFor(std::chrono::seconds(3));
  ASSERT_TRUE(files.contains("last_selfcheck_info.json"));
  const Json found = Json::parse(files.at("last_selfcheck_info.json"));
  EXPECT_EQ(found["a"], 0);
  EXPECT_EQ(found["device"]["bms"], -1) << "there is no device_manager";
}

TEST(SerialNumber, IsThatOfTheFirstFileThatHasOne) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "serial";
  std::filesystem::create_directories(folder);
  const std::string empty = folder / "empty", number = folder / "number", other = folder / "other";
  std::ofstream(empty) << " \n";
  std::ofstream(number) << std::string("1421619\n\0", 9);
  std::ofstream(other) << "17";
  EXPECT_EQ(cyberdog::ReadSerialNumber({folder / "none", empty, number, other}), "1421619");
  EXPECT_EQ(cyberdog::ReadSerialNumber({folder / "none"}), "");
  std::ofstream(other) << std::string(1000, 'x');
  EXPECT_EQ(cyberdog::ReadSerialNumber({other}), std::string(64, 'x'));
  std::filesystem::remove_all(folder);
}

TEST_F(CyberdogInformation, ARequestOfUnknownFieldsIsRefused) {
  BringUp();
  const auto answer = Call<msg::DeviceInfo>("query_divice_info", {std::vector<bool>(16, true), ""});
  EXPECT_EQ(answer.code, kCodeParametersInvalid);
  EXPECT_EQ(answer.info, "");
}

}  // namespace musher::testing::information_test
