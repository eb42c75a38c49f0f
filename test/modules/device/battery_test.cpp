#include "musher/modules/device/battery.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace musher::device::battery_test {

using msg::BatteryState;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

BatteryReading At(double percent) {
  BatteryReading reading;
  reading.percent = percent;
  return reading;
}

// The readings that a filter passes on.
std::vector<double> Passed(const std::vector<double>& readings) {
  BatteryFilter filter;
  std::vector<double> passed;
  for (const double percent : readings) {
    if (const auto counts = filter.Take(At(percent))) passed.push_back(counts->percent);
  }
  return passed;
}

TEST(BatteryFilter, PassesSmallStepsAtOnce) {
  EXPECT_THAT(Passed({80, 79, 78, 73}), ElementsAre(79, 78, 73));
}

TEST(BatteryFilter, PassesNothingBeforeTheFirstReadingIsConfirmed) {
  EXPECT_THAT(Passed({0}), IsEmpty());
  EXPECT_THAT(Passed({0, 80}), IsEmpty());
  EXPECT_THAT(Passed({0, 80, 80}), ElementsAre(80));
}

TEST(BatteryFilter, NeverPassesASingleWrongValue) {
  EXPECT_THAT(Passed({80, 80, 0, 79, 78}), ElementsAre(80, 79, 78));
  EXPECT_THAT(Passed({80, 80, 30, 100, 79}), ElementsAre(80, 79));
}

TEST(BatteryFilter, PassesAJumpThatIsConfirmed) {
  EXPECT_THAT(Passed({80, 80, 30, 30}), ElementsAre(80, 30));
  EXPECT_THAT(Passed({10, 10, 60, 62}), ElementsAre(10, 62));
}

TEST(BatteryFilter, PassesABatteryThatFallsInStepsOf30Percent) {
  EXPECT_THAT(Passed({100, 100, 70, 40, 10, 0, 0}), ElementsAre(100, 70, 40, 10, 0));
}

TEST(BatteryFilter, PassesTheNearerOfTwoThatJumpTheSameWay) {
  EXPECT_THAT(Passed({80, 80, 0, 50, 50}), ElementsAre(80, 50, 50));
}

std::vector<double> AnyCharges(std::size_t least) {
  std::vector<double> charges;
  const auto count = *rc::gen::inRange<std::size_t>(least, least + 30);
  for (std::size_t i = 0; i < count; ++i) charges.push_back(*rc::gen::inRange(0, 101));
  return charges;
}

RC_GTEST_PROP(BatteryFilter, PassesALevelThatStaysWhateverWasBefore, ()) {
  std::vector<double> readings = AnyCharges(0);
  const double level = *rc::gen::inRange(0, 101);
  readings.insert(readings.end(), 3, level);
  RC_ASSERT(Passed(readings).back() == level);
}

RC_GTEST_PROP(BatteryFilter, MissesNoLevelOfAFallOfWhateverSteps, ()) {
  std::vector<double> readings = AnyCharges(2);
  std::sort(readings.rbegin(), readings.rend());
  readings.insert(readings.end(), 3, readings.back());
  const std::vector<double> passed = Passed(readings);
  RC_ASSERT(std::is_sorted(passed.rbegin(), passed.rend()));
  for (std::size_t i = 1; i < readings.size(); ++i) {
    RC_ASSERT(std::any_of(passed.begin(), passed.end(), [&](double percent) {
      return std::abs(percent - readings[i]) <= BatteryFilter::kJumpPercent;
    }));
  }
}

RC_GTEST_PROP(BatteryFilter, PassesNoSingleWrongValue, ()) {
  std::vector<double> readings;
  double true_charge = *rc::gen::inRange(20, 81);
  const auto count = *rc::gen::inRange(3, 40);
  int since_wrong = 2;
  for (int i = 0; i < count; ++i) {
    true_charge += *rc::gen::inRange(-1, 2) * 0.5;
    const bool wrong = since_wrong >= 2 && *rc::gen::arbitrary<bool>();
    since_wrong = wrong ? 0 : since_wrong + 1;
    readings.push_back(wrong ? 500 : true_charge);
  }
  for (const double percent : Passed(readings)) RC_ASSERT(percent < 500);
}

BatteryState State(float percentage) {
  BatteryState state;
  state.percentage = percentage;
  state.present = true;
  state.voltage = 25.2F;
  state.current = -1.5F;
  state.temperature = 31.4F;
  return state;
}

TEST(Battery, IsConvertedToTheUnitsOfBmsStatus) {
  BatteryState state = State(0.424F);
  state.capacity = 4.5F;
  state.design_capacity = 5;
  const msg::BmsStatus status = ToBmsStatus(FromMessage(state), true);
  EXPECT_EQ(status.batt_soc, 42);
  EXPECT_EQ(status.batt_volt, 25'200);
  EXPECT_EQ(status.batt_curr, -1500);
  EXPECT_EQ(status.batt_temp, 31);
  EXPECT_EQ(status.batt_health, 90);
  EXPECT_TRUE(status.power_normal);
  EXPECT_FALSE(status.power_wired_charging);
  EXPECT_FALSE(status.power_motor_shutdown);
}

TEST(Battery, LeavesOutWhatIsNotMeasured) {
  BatteryState state = State(1);
  state.voltage = state.current = state.temperature = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(Validate(FromMessage(state)));
  const msg::BmsStatus status = ToBmsStatus(FromMessage(state), false);
  EXPECT_EQ(status.batt_soc, 100);
  EXPECT_EQ(status.batt_volt, 0);
  EXPECT_EQ(status.batt_curr, 0);
  EXPECT_EQ(status.batt_health, 0);
  EXPECT_TRUE(status.power_motor_shutdown);
}

TEST(Battery, SaturatesACurrentThatTheMessageCannotCarry) {
  BatteryState state = State(0.5F);
  state.current = -40;
  EXPECT_EQ(ToBmsStatus(FromMessage(state), true).batt_curr, -32'768);
}

TEST(Battery, ReportsWhetherItChargesAndWhetherItIsFull) {
  BatteryState state = State(0.5F);
  state.power_supply_status = BatteryState::kStatusCharging;
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).power_wired_charging);
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).power_expower_supply);
  EXPECT_FALSE(ToBmsStatus(FromMessage(state), true).power_finished_charging);
  state.power_supply_status = BatteryState::kStatusFull;
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).power_wired_charging);
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).power_finished_charging);
  state.power_supply_status = BatteryState::kStatusNotCharging;
  EXPECT_FALSE(ToBmsStatus(FromMessage(state), true).power_wired_charging);
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).power_expower_supply);
}

TEST(Battery, ReportsItsFaults) {
  BatteryState state = State(0.5F);
  state.power_supply_health = BatteryState::kHealthOverheat;
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).discharge_over_tmp);
  EXPECT_FALSE(ToBmsStatus(FromMessage(state), true).power_normal);
  state.power_supply_status = BatteryState::kStatusCharging;
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).charge_over_temp);
  state.power_supply_health = BatteryState::kHealthOvervoltage;
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).cell_over_voltage);
  state.power_supply_health = BatteryState::kHealthDead;
  EXPECT_TRUE(ToBmsStatus(FromMessage(state), true).cell_volt_abnormal);
}

TEST(Battery, IsRefusedWhenItIsImpossible) {
  const auto why = [](auto change) {
    BatteryState state = State(0.5F);
    change(state);
    const Result<> valid = Validate(FromMessage(state));
    return valid ? "" : std::to_string(valid.error().code) + " " + valid.error().message;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(why([](BatteryState&) {}), "");
  EXPECT_EQ(why([](BatteryState& s) { s.percentage = kNan; }),
            "1410 a charge that is not a number");
  EXPECT_THAT(why([](BatteryState& s) { s.percentage = 1.2F; }), HasSubstr("1410 a charge"));
  EXPECT_THAT(why([](BatteryState& s) { s.percentage = -0.1F; }), HasSubstr("1410 a charge"));
  EXPECT_THAT(why([](BatteryState& s) { s.percentage = kInf; }), HasSubstr("1410 a charge"));
  EXPECT_THAT(why([](BatteryState& s) { s.voltage = -1; }), HasSubstr("1410 a voltage"));
  EXPECT_THAT(why([](BatteryState& s) { s.voltage = kInf; }), HasSubstr("1410 a voltage"));
  EXPECT_THAT(why([](BatteryState& s) { s.current = -kInf; }), HasSubstr("1410 a current"));
  EXPECT_THAT(why([](BatteryState& s) { s.temperature = 400; }), HasSubstr("1410 a temperature"));
  EXPECT_EQ(why([](BatteryState& s) { s.present = false; }), "1412 there is no battery");
}

}  // namespace musher::device::battery_test
