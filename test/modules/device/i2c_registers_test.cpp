// What the registers of a device on an I2C bus mean, and when a reading is believed.

#include "musher/modules/device/i2c_registers_toml.hpp"

#include <gmock/gmock.h>

#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::device::i2c_registers_test {

using std::chrono::seconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::UnorderedElementsAre;

RegisterValue Value(std::size_t bytes, bool is_signed = false, bool little_endian = true) {
  RegisterValue value;
  value.name = "voltage";
  value.address = 0x2C;
  value.bytes = bytes;
  value.is_signed = is_signed;
  value.little_endian = little_endian;
  value.unit = "mV";
  return value;
}

TEST(RegisterValue, HasBytesInEitherOrder) {
  EXPECT_EQ(DecodeRegister(Value(2), {0x34, 0x12}).value(), 0x1234);
  EXPECT_EQ(DecodeRegister(Value(2, false, false), {0x12, 0x34}).value(), 0x1234);
  EXPECT_EQ(DecodeRegister(Value(4), {0x78, 0x56, 0x34, 0x12}).value(), 0x12345678);
  EXPECT_EQ(DecodeRegister(Value(1), {0xFF}).value(), 255);
}

TEST(RegisterValue, MayBeNegative) {
  EXPECT_EQ(DecodeRegister(Value(1, true), {0xFF}).value(), -1);
  EXPECT_EQ(DecodeRegister(Value(2, true, false), {0xFF, 0xFE}).value(), -2);
  EXPECT_EQ(DecodeRegister(Value(4, true), {0, 0, 0, 0x80}).value(), -2147483648.0);
}

TEST(RegisterValue, IsScaled) {
  RegisterValue value = Value(2, true, false);  // as of a TMP102, whose lowest four bits are 0
  value.zoom = 1.0 / 256;
  value.offset = 0.5;
  EXPECT_DOUBLE_EQ(DecodeRegister(value, {0x19, 0x80}).value(), 26.0);
}

TEST(RegisterValue, MayBeInBits) {
  RegisterValue value = Value(2);
  value.bits = {11, 8};
  EXPECT_EQ(DecodeRegister(value, {0xFF, 0xA5}).value(), 5);
  value.bytes = 4;
  value.bits = {31, 0};
  EXPECT_EQ(DecodeRegister(value, {0xFF, 0xFF, 0xFF, 0xFF}).value(), 4294967295.0);
}

TEST(RegisterValue, BeyondItsLimitsIsRefusedWithItsUnit) {
  RegisterValue value = Value(2);
  value.least = 9000;
  value.most = 17000;
  EXPECT_TRUE(DecodeRegister(value, {0x28, 0x23}));
  const auto refused = DecodeRegister(value, {0xFF, 0xFF});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message,
            "register 0x2C has 65535 mV for 'voltage', which is from 9000 mV up to 17000 mV");
  EXPECT_EQ(refused.error().code, static_cast<std::int32_t>(KeyCode::kParametersInvalid));
}

// --- a reading of several registers ---

class RecordOfRegisters : public ::testing::Test {
 protected:
  RecordOfRegisters() {
    values_ = {Value(1), Value(1)};
    values_[1].name = "charge";
    values_[1].address = 0x2D;
    values_[1].unit = "%";
  }
  // A second after the last one.
  Result<std::optional<I2cRecord::Values>> Take(std::uint8_t voltage, std::uint8_t charge) {
    if (!record_) record_.emplace(values_);
    return record_->Take({{voltage}, {charge}}, now_ += seconds(1));
  }
  bool Counts(std::uint8_t voltage, std::uint8_t charge) {
    const auto taken = Take(voltage, charge);
    return taken && taken.value();
  }

  Time now_{seconds(100)};
  std::vector<RegisterValue> values_;
  std::optional<I2cRecord> record_;
};

TEST_F(RecordOfRegisters, HasAllValues) {
  EXPECT_THAT(Take(12, 80).value().value(),
              UnorderedElementsAre(Pair("voltage", 12), Pair("charge", 80)));
}

TEST_F(RecordOfRegisters, CountsNotIfOneIsBeyondItsLimits) {
  values_[1].most = 100;
  EXPECT_FALSE(Take(12, 101));
  EXPECT_TRUE(Counts(12, 100));
}

TEST_F(RecordOfRegisters, BelievesAJumpThatTheNextReadingConfirms) {
  values_[1].jump = 5;
  EXPECT_FALSE(Counts(12, 80)) << "the first one: the device may not have measured yet";
  EXPECT_TRUE(Counts(12, 80));
  EXPECT_FALSE(Counts(12, 0)) << "one wrong reading";
  EXPECT_TRUE(Counts(12, 79));
  EXPECT_FALSE(Counts(12, 40));
  EXPECT_TRUE(Counts(12, 39)) << "a true fall, one reading late";
}

TEST_F(RecordOfRegisters, BelievesTwoJumpsOneAfterTheOther) {
  values_[0].jump = 5;
  values_[1].jump = 5;
  ASSERT_FALSE(Counts(12, 80));
  ASSERT_TRUE(Counts(12, 80));
  EXPECT_FALSE(Counts(24, 80));
  EXPECT_FALSE(Counts(24, 40));
  EXPECT_TRUE(Counts(24, 40));
}

TEST_F(RecordOfRegisters, RefusesAValueThatIsStuck) {
  values_[0].stuck_after = seconds(3);
  EXPECT_TRUE(Counts(12, 80));
  EXPECT_TRUE(Counts(12, 79));
  EXPECT_TRUE(Counts(12, 78));
  const auto stuck = Take(12, 77);
  ASSERT_FALSE(stuck);
  EXPECT_EQ(stuck.error().message,
            "register 0x2C has had 12 mV for 'voltage' for 3000 ms: the device is stuck");
  EXPECT_TRUE(Counts(13, 77));
}

// --- its file ---

constexpr const char* kHead = "bus = \"/dev/i2c-1\"\naddress = \"0x48\"\n";
constexpr const char* kVar = "[[var]]\nregister = \"0x00\"\nvar_name = \"hall\"\nvar_type = ";

Parsed<I2cProtocol> Read(const std::string& text) {
  return ReadI2cText(text, "/robot/sensor.toml", {});
}

TEST(RegisterFile, HasTheValuesOfTheFile) {
  const auto reading = Read(R"(
protocol = "i2c"
name = "thermometer"
bus = "/dev/i2c-7"
address = "0x48"
period_ms = 200
[[var]]
register = "0x1F"
var_name = "board_temperature"
var_type = "i16"
byte_order = "big"
var_zoom = 0.5
offset = -1
least = -40
most = 125
jump = 2.5
stuck_after_ms = 60000
unit = "degrees Celsius"
[[var]]
register = "0x20"
var_name = "state"
var_type = "u8"
bits = [6, 5]
)");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  RegisterValue temperature;
  temperature.name = "board_temperature";
  temperature.address = 0x1F;
  temperature.bytes = 2;
  temperature.is_signed = true;
  temperature.little_endian = false;
  temperature.zoom = 0.5;
  temperature.offset = -1;
  temperature.least = -40;
  temperature.most = 125;
  temperature.jump = 2.5;
  temperature.stuck_after = seconds(60);
  temperature.unit = "degrees Celsius";
  RegisterValue state;
  state.name = "state";
  state.address = 0x20;
  state.bits = {6, 5};
  I2cProtocol expected{"/dev/i2c-7", 0x48, Milliseconds(200), {temperature, state}};
  EXPECT_EQ(*reading.config, expected);
}

TEST(RegisterFile, ReportsWhatIsWrongAndWhere) {
  const std::string head = kHead;
  const std::string var = head + kVar;
  musher::testing::ExpectDiagnostics(
      Read,
      {{"no bus",
        "address = \"0x48\"\n" + std::string(kVar) + "\"u8\"\n",
        {"the key \"bus\" is missing"}},
       {"an address of the bus itself",
        "bus = \"/dev/i2c-1\"\naddress = \"0x78\"\n" + std::string(kVar) + "\"u8\"\n",
        {":2:11: error: address: expected a hexadecimal number from 0x08 to 0x77, found \"0x78\""}},
       {"no value", head, {"var: expected a [[var]] for each value"}},
       {"no byte order", var + "\"u16\"\n", {"the key \"byte_order\" is missing"}},
       {"an unknown type", var + "\"u64\"\n", {"var_type: expected one of u8, u16, u32"}},
       {"bits beyond the register", var + "\"u8\"\nbits = [8, 0]\n", {"bits: expected"}},
       {"bits in the wrong order", var + "\"u8\"\nbits = [1, 2]\n", {"expected [high, low]"}},
       {"bits of a signed one",
        var + "\"i8\"\nbits = [2, 1]\n",
        {"bits are of type u8, u16 or u32"}},
       {"limits in the wrong order",
        var + "\"u8\"\nleast = 5\nmost = 4\n",
        {"expected least or more"}},
       {"stuck before the next reading",
        var + "\"u8\"\nstuck_after_ms = 1000\n",
        {"stuck_after_ms: expected more than period_ms"}},
       {"a name that no topic may have",
        head + "[[var]]\nregister = \"0x00\"\nvar_name = \"a b\"\nvar_type = \"u8\"\n",
        {"var_name: expected"}},
       {"a name twice",
        var + "\"u8\"\n" + kVar + "\"u8\"\n",
        {"\"hall\" is defined above already"}},
       {"a register that is no byte",
        head + "[[var]]\nregister = \"0x100\"\nvar_name = \"hall\"\nvar_type = \"u8\"\n",
        {"register: expected a hexadecimal number from 0x00 to 0xFF"}}});
}

TEST(RegisterFile, OfABatteryHasItsNames) {
  const RegisterNames names{{"batt_soc", "batt_volt"}, "batt_soc"};
  const auto reading =
      ReadI2cText(std::string(kHead) +
                      "[[var]]\nregister = \"0x00\"\nvar_name = \"batt_vol\"\nvar_type = \"u8\"\n",
                  "b.toml", names);
  EXPECT_THAT(musher::testing::Lines(reading.diagnostics),
              UnorderedElementsAre(HasSubstr("did you mean \"batt_volt\"?"),
                                   HasSubstr("there is no \"batt_soc\"")));
}

TEST(RegisterFile, ThatIsShippedIsGood) {
  const RegisterNames battery{
      {"batt_soc", "batt_volt", "batt_curr", "batt_temp", "batt_health", "batt_loop_number"},
      "batt_soc"};
  for (const auto& [file, names] :
       {std::pair("battery.toml", battery), std::pair("thermometer.toml", RegisterNames{})}) {
    const auto reading = ReadI2cFile(SourceDir() + "/config/device/i2c/" + file, names);
    EXPECT_THAT(reading.diagnostics, IsEmpty()) << file;
    EXPECT_TRUE(reading.config) << file;
  }
}

}  // namespace musher::device::i2c_registers_test
