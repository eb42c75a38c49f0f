// What frames of a CAN bus mean: values, records, commands, and the files that define them.

#include "musher/modules/device/can_protocol.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cstring>
#include <limits>
#include <string>

#include "musher/modules/device/can_battery.hpp"
#include "musher/modules/device/can_lights.hpp"
#include "musher/modules/device/can_protocol_toml.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::device::can_protocol_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr CanId kId{0x123, false};

CanFrame Frame(const CanId& id, std::initializer_list<int> bytes) {
  CanFrame frame;
  frame.id = id;
  for (const int byte : bytes) frame.data.at(frame.size++) = static_cast<std::uint8_t>(byte);
  return frame;
}

CanField Field(std::size_t first, std::size_t last, CanType type = CanType::kUnsigned) {
  CanField field;
  field.name = "x";
  field.id = kId;
  field.type = type;
  field.first = first;
  field.last = last;
  return field;
}

// The examples of CyberDog's description of its files.
TEST(CanValue, IsTheNumberInItsBytes) {
  const CanFrame frame = Frame(kId, {0x12, 0x34, 0x56, 0x78});
  EXPECT_EQ(Decode(Field(1, 2), frame).value(), 0x3456);
  CanField little = Field(1, 2);
  little.little_endian = true;
  EXPECT_EQ(Decode(little, frame).value(), 0x5634);
  CanField scaled = Field(0, 3, CanType::kSigned);
  scaled.zoom = 0.5;
  scaled.offset = -40;
  EXPECT_EQ(Decode(scaled, frame).value(), 0x12345678 * 0.5 - 40);
  CanField bits = Field(1, 1);
  bits.bits = CanField::Bits{5, 4};
  EXPECT_EQ(Decode(bits, frame).value(), 3);
  EXPECT_EQ(Decode(Field(0, 0, CanType::kSigned), Frame(kId, {0xFF})).value(), -1);
  const float quarter = -0.25F;
  std::array<std::uint8_t, sizeof quarter> bytes{};
  std::memcpy(bytes.data(), &quarter, sizeof quarter);
  const CanFrame floating = Frame(kId, {bytes[3], bytes[2], bytes[1], bytes[0]});
  EXPECT_EQ(Decode(Field(0, 3, CanType::kFloat), floating).value(), -0.25);
}

RC_GTEST_PROP(CanValue, OfEachInteger16IsTheSameInBothByteOrders, (std::int16_t value)) {
  const auto raw = static_cast<std::uint16_t>(value);
  const CanFrame big = Frame(kId, {raw >> 8, raw & 0xFF});
  const CanFrame small = Frame(kId, {raw & 0xFF, raw >> 8});
  CanField field = Field(0, 1, CanType::kSigned);
  RC_ASSERT(Decode(field, big).value() == value);
  field.little_endian = true;
  RC_ASSERT(Decode(field, small).value() == value);
}

RC_GTEST_PROP(CanValue, OfAnyFrameIsANumberOrRefused,
              (std::array<std::uint8_t, kCanBytes> data, std::uint8_t size, bool remote)) {
  const CanFrame frame{kId, static_cast<std::uint8_t>(size % (kCanBytes + 1)), data, remote};
  for (const CanType type : {CanType::kUnsigned, CanType::kSigned, CanType::kFloat}) {
    const auto value = Decode(Field(0, 7, type), frame);
    if (!value) continue;
    RC_ASSERT(std::isfinite(value.value()));
    RC_ASSERT(frame.size == kCanBytes);
  }
}

TEST(CanValue, IsRefusedWithACodeAndASentence) {
  const auto refused = [](const CanField& field, const CanFrame& frame) {
    const auto value = Decode(field, frame);
    EXPECT_FALSE(value);
    return value ? "" : std::to_string(value.error().code) + " " + value.error().message;
  };
  EXPECT_EQ(refused(Field(2, 3), Frame(kId, {1, 2, 3})),
            "10 frame 0x123 has 3 bytes, and 'x' is in byte 3");
  CanFrame remote = Frame(kId, {1});
  remote.remote = true;
  EXPECT_EQ(refused(Field(0, 0), remote), "10 frame 0x123 asks for data and has none");
  EXPECT_EQ(refused(Field(0, 3, CanType::kFloat), Frame(kId, {0x7F, 0xC0, 0, 0})),
            "10 frame 0x123 has a 'x' that is no number");
  CanField percent = Field(0, 0);
  percent.id = {0x834100, true};
  percent.least = 0;
  percent.most = 100;
  EXPECT_EQ(refused(percent, Frame(percent.id, {153})),
            "10 frame 0x00834100 has 153 for 'x', which is from 0 up to 100");
}

TEST(CanRecord, IsCompleteOnceEachOfItsFramesHasCome) {
  CanField one = Field(0, 0);
  CanField other = Field(0, 0);
  other.name = "y";
  other.id = {0x124, false};
  other.most = 9;
  CanRecord record({one, other});
  EXPECT_FALSE(record.Take(Frame(one.id, {1})).value());
  EXPECT_FALSE(record.Take(Frame(one.id, {2})).value()) << "the same once more";
  EXPECT_THAT(record.Missing(), ElementsAre(other.id));
  EXPECT_FALSE(record.Take(Frame(other.id, {10}))) << "refused";
  EXPECT_THAT(record.Missing(), ElementsAre(other.id));
  EXPECT_TRUE(record.Take(Frame(other.id, {3})).value());
  EXPECT_THAT(record.values(), ElementsAre(Pair("x", 2), Pair("y", 3)));
  EXPECT_FALSE(record.Take(Frame(other.id, {4})).value()) << "of the next record";
  record.Forget();
  EXPECT_FALSE(record.Take(Frame(one.id, {5})).value()) << "the bus was lost between them";
  EXPECT_FALSE(record.Knows({one.id.number, true})) << "29 bits are another id";
}

TEST(CanCommand, HasItsControlBytesBeforeItsData) {
  const CanCommand command{"go", {0x1F2, false}, {0xA1, 0xA2, 0, 0}};
  const std::array<std::uint8_t, 2> data = {0x12, 0x34};
  EXPECT_EQ(Encode(command, data),
            (CanFrame{{0x1F2, false}, 8, {0xA1, 0xA2, 0, 0, 0x12, 0x34, 0, 0}, false}));
}

TEST(CanFile, OfTheBatteryOfACyberDog2HasItsFrames) {
  const auto file = ReadCanFile(SourceDir() + "/config/device/can/battery.toml", BatteryCanNames());
  EXPECT_THAT(file.diagnostics, IsEmpty());
  ASSERT_TRUE(file.config);
  CanRecord record(file.config->fields);
  // 78 %, 25,860 mV, -1,250 mA, 31 °C; 300 cycles, 97 %; charging from outside, the motors are off.
  ASSERT_TRUE(record.Take(Frame({0x834100, true}, {78, 0x04, 0x65, 0x1E, 0xFB, 31, 0, 0})));
  ASSERT_TRUE(record.Take(Frame({0x834101, true}, {0x2C, 0x01, 97, 0, 0, 0x8A, 0, 0})).value());
  const BatteryReading reading = FromRecord(record.values());
  EXPECT_EQ(reading.percent, 78);
  EXPECT_NEAR(reading.voltage_v, 25.86, 1e-9);
  EXPECT_NEAR(reading.current_a, -1.25, 1e-9);
  EXPECT_EQ(reading.temperature_c, 31);
  EXPECT_EQ(reading.cycles, 300);
  EXPECT_EQ(reading.health_percent, 97);
  EXPECT_EQ(reading.status, msg::BatteryState::kStatusCharging);
  EXPECT_TRUE(reading.external_power);
  EXPECT_EQ(record.values().at("power_motor_shutdown"), 1);
}

TEST(CanFile, OfThisTreeIsValid) {
  for (const char* const light : {"head_led", "mini_led"}) {
    const auto file = ReadCanFile(
        SourceDir() + "/config/device/can/" + std::string(light) + ".toml", LightCanNames());
    EXPECT_THAT(file.diagnostics, IsEmpty()) << light;
    EXPECT_TRUE(file.config) << light;
  }
}

Parsed<CanProtocol> Read(const std::string& text) {
  return ReadCanText(text, "b.toml", BatteryCanNames());
}

// CyberDog's rule: "float" in 2 bytes is an integer, which var_zoom scales.
TEST(CanFile, ReadsAFloatInFewerBytesAsAScaledInteger) {
  const auto file = Read(
      "can_interface = \"can0\"\n[[var]]\ncan_id = \"0x1'23\"\nvar_name = \"batt_soc\"\n"
      "var_type = \"float\"\nparser_param = [0, 1]\nvar_zoom = 0.1\n");
  ASSERT_TRUE(file.config) << file.diagnostics.front().message;
  EXPECT_NEAR(Decode(file.config->fields.front(), Frame(kId, {0x03, 0x0C})).value(), 78, 1e-9);
}

// A table of five lines.
std::string Var(const std::string& id, const std::string& name, const std::string& type,
                const std::string& place) {
  return "[[var]]\ncan_id = \"" + id + "\"\nvar_name = \"" + name + "\"\nvar_type = \"" + type +
         "\"\nparser_param = " + place + "\n";
}

TEST(CanFile, ReportsWhatIsWrongAndWhere) {
  const std::string bus = "can_interface = \"can0\"\n";
  const std::string good = Var("0x123", "batt_soc", "u8", "[0, 0]");
  const auto placed = [&](const std::string& type, const std::string& place) {
    return bus + Var("0x123", "batt_soc", type, place);
  };
  musher::testing::ExpectDiagnostics(
      Read,
      {{"no bus, no charge",
        "",
        {"the key \"can_interface\" is missing", "var: there is no \"batt_soc\""}},
       {"another protocol",
        "protocol = \"i2c\"\n" + bus + good,
        {":1:12: error: protocol: expected"}},
       {"CAN FD",
        "canfd_enable = true\n" + bus + good,
        {":1:16: error: canfd_enable: expected false"}},
       {"an array",
        bus + good + "[[array]]\narray_name = \"battery_status\"\n",
        {"array: expected a [[var]] for each value"}},
       {"a timeout of another program",
        "timeout_us = 5\n" + bus + good,
        {":1:14: warning: timeout_us: has no effect"}},
       {"an id of 29 bits that has 11",
        bus + Var("0x00834100", "batt_soc", "u8", "[0, 0]"),
        {":3:10: error: var.can_id: expected a hexadecimal number from 0x000 to 0x7FF"}},
       {"an id that is no number",
        bus + Var("12", "batt_soc", "u8", "[0, 0]"),
        {"var.can_id: expected a hexadecimal number"}},
       {"an unknown name",
        bus + good + Var("0x123", "bat_volt", "u8", "[0, 0]"),
        {"did you mean \"batt_volt\"?"}},
       {"a name twice",
        bus + good + good,
        {":9:12: error: var.var_name: \"batt_soc\" is defined above already"}},
       {"an unknown key", bus + good + "zoom = 2\n", {":7:1: error: var: unknown key \"zoom\""}},
       {"a type of another size",
        placed("u16", "[0, 2]"),
        {":6:16: error: var.parser_param: expected 2 bytes for this var_type, found 3"}},
       {"a byte beyond the frame", placed("u8", "[8, 8]"), {"from 0 to 7", "from 0 to 7"}},
       {"the last byte first", placed("u16", "[2, 1]"), {"expected the first byte before"}},
       {"bits of two bytes", placed("u16", "[0, 5, 4]"), {"bits are of type u8 or bool"}},
       {"bits in the wrong order",
        placed("u8", "[0, 4, 5]"),
        {"expected the high bit before the low bit"}},
       {"no place", placed("u8", "[0]"), {"[first byte, last byte]"}},
       {"limits in the wrong order",
        bus + good + "least = 5\nmost = 1\n",
        {":8:8: error: var.most: expected least or more"}},
       {"more control bytes than its length",
        bus + good +
            "[[cmd]]\ncmd_name = \"cmd_normal_mode\"\ncan_id = \"0x1\"\nctrl_len = 1\n"
            "ctrl_data = [\"0x00\", \"0x100\"]\n",
        {"cmd.ctrl_data: expected at most ctrl_len bytes", "expected a byte such as"}}});
}

TEST(CanFile, OfALightNeedsItsCommand) {
  const auto file = ReadCanText("can_interface = \"can0\"\n", "l.toml", LightCanNames());
  ASSERT_EQ(file.diagnostics.size(), 1U);
  EXPECT_THAT(file.diagnostics.front().message, HasSubstr("there is no \"enable_on\""));
}

}  // namespace musher::device::can_protocol_test
