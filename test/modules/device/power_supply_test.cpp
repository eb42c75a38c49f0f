#include "musher/modules/device/power_supply.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "musher/test/support/temp_folder.hpp"

namespace musher::device::power_supply_test {

using msg::BatteryState;
using ::testing::HasSubstr;

class PowerSupply : public ::testing::Test {
 protected:
  // A supply as the kernel shows it: a file for each value.
  void Supply(const std::string& name, const std::map<std::string, std::string>& values) const {
    std::filesystem::create_directories(folder_ / name);
    for (const auto& [file, value] : values)
      std::ofstream(folder_ / (name + "/" + file)) << value << "\n";
  }
  Result<BatteryReading> Read(const std::string& name = "") const {
    return ReadHostBattery(folder_.path(), name);
  }

  const TempFolder folder_;
};

TEST_F(PowerSupply, ReadsABattery) {
  Supply("AC", {{"type", "Mains"}, {"online", "0"}});
  Supply("BAT0", {{"type", "Battery"},
                  {"status", "Discharging"},
                  {"capacity", "47"},
                  {"voltage_now", "11580000"},
                  {"current_now", "1250000"},
                  {"temp", "312"},
                  {"health", "Good"},
                  {"cycle_count", "211"},
                  {"energy_full", "45000000"},
                  {"energy_full_design", "50000000"}});
  const auto reading = Read();
  ASSERT_TRUE(reading) << reading.error().message;
  const msg::BmsStatus status = ToBmsStatus(reading.value(), true);
  EXPECT_EQ(status.batt_soc, 47);
  EXPECT_EQ(status.batt_volt, 11'580);
  EXPECT_EQ(status.batt_curr, -1250);
  EXPECT_EQ(status.batt_temp, 31);
  EXPECT_EQ(status.batt_health, 90);
  EXPECT_EQ(status.batt_loop_number, 211);
  EXPECT_FALSE(status.power_wired_charging);
  EXPECT_FALSE(status.power_expower_supply);
}

TEST_F(PowerSupply, ComputesValuesThatTheDriverLacks) {
  Supply("BAT1", {{"type", "Battery"},
                  {"status", "Charging"},
                  {"charge_now", "1000000"},
                  {"charge_full", "4000000"},
                  {"voltage_now", "10000000"},
                  {"power_now", "20000000"}});
  Supply("USB", {{"type", "USB"}, {"online", "1"}});
  const auto reading = Read();
  ASSERT_TRUE(reading) << reading.error().message;
  EXPECT_DOUBLE_EQ(reading.value().percent, 25);
  EXPECT_DOUBLE_EQ(reading.value().current_a, 2);
  EXPECT_TRUE(reading.value().Charging());
  EXPECT_TRUE(reading.value().external_power);
  EXPECT_TRUE(std::isnan(reading.value().temperature_c));
  EXPECT_TRUE(std::isnan(reading.value().health_percent));
}

TEST_F(PowerSupply, TakesTheFirstBatteryThatFeedsTheHostUnlessOneIsNamed) {
  Supply("BAT1", {{"type", "Battery"}, {"capacity", "10"}});
  Supply("BAT0", {{"type", "Battery"}, {"capacity", "90"}});
  Supply("A_mouse", {{"type", "Battery"}, {"scope", "Device"}, {"capacity", "50"}});
  EXPECT_EQ(Read().value().percent, 90);
  EXPECT_EQ(Read("BAT1").value().percent, 10);
  EXPECT_EQ(Read("A_mouse").value().percent, 50);
}

TEST_F(PowerSupply, ReportsWhichOneIsMissing) {
  Supply("AC", {{"type", "Mains"}});
  EXPECT_EQ(Read().error().code, 1412);
  EXPECT_THAT(Read().error().message, HasSubstr("has no battery"));
  EXPECT_THAT(Read("BAT7").error().message, HasSubstr("has no supply 'BAT7'"));
  EXPECT_THAT(ReadHostBattery(folder_ / "nowhere", "").error().message,
              HasSubstr("No such file or directory"));
}

TEST_F(PowerSupply, IsInvalidWithoutAChargeOrWithImpossibleValues) {
  Supply("BAT0", {{"type", "Battery"}, {"status", "Full"}});
  EXPECT_FALSE(Validate(Read().value()));
  Supply("BAT0", {{"capacity", "lots"}});
  EXPECT_FALSE(Validate(Read().value()));
  Supply("BAT0", {{"capacity", "250"}});
  EXPECT_FALSE(Validate(Read().value()));
  Supply("BAT0", {{"capacity", "25"}});
  EXPECT_TRUE(Validate(Read().value()));
  Supply("BAT0", {{"present", "0"}});
  EXPECT_FALSE(Validate(Read().value()));
}

TEST_F(PowerSupply, ReadsTheWordsOfTheKernel) {
  const auto flags = [this](const std::string& status, const std::string& health) {
    Supply("BAT0",
           {{"type", "Battery"}, {"capacity", "50"}, {"status", status}, {"health", health}});
    return ToBmsStatus(Read().value(), true);
  };
  EXPECT_TRUE(flags("Full", "Good").power_finished_charging);
  EXPECT_TRUE(flags("Charging", "Overheat").charge_over_temp);
  EXPECT_TRUE(flags("Discharging", "Hot").discharge_over_tmp);
  EXPECT_TRUE(flags("Not charging", "Cold").discharge_under_tmp);
  EXPECT_TRUE(flags("Unknown", "Over voltage").cell_over_voltage);
  EXPECT_TRUE(flags("Unknown", "Unspecified failure").cell_volt_abnormal);
  EXPECT_TRUE(flags("Unknown", "Dead").cell_volt_abnormal);
  EXPECT_TRUE(flags("", "").power_normal);
}

}  // namespace musher::device::power_supply_test
