// The battery and sensors on I2C buses, in virtual time, with registers of the test; and a device
// of Linux on a bus of i2c-stub where this kernel has it.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/modules/device/i2c_file.hpp"
#include "musher/test/modules/device/devices_fixture.hpp"
#include "musher/test/modules/device/fake_i2c.hpp"
#include "musher/test/support/wait.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::device::i2c_devices_test {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

RegisterValue Register(std::uint8_t address, const std::string& name, std::size_t bytes) {
  RegisterValue value;
  value.address = address;
  value.name = name;
  value.bytes = bytes;
  return value;
}

class I2cDevices : public DevicesOnANetwork {
 protected:
  I2cDevices() {
    config_.touch.source = KeySource::kNone;
    config_.led.source = LedSource::kNone;
    config_.battery.source = BatterySource::kNone;
  }
  void Start() {
    Dependencies dependencies = Around();
    dependencies.i2c = i2c_.Door();
    devices_ = test::Must(Devices::Make(dependencies, config_));
    Run(Milliseconds(500));  // discovery
  }

  FakeI2c i2c_;
};

// --- the battery ---

class I2cBattery : public I2cDevices {
 protected:
  I2cBattery() {
    RegisterValue charge = Register(0x2C, "batt_soc", 2);
    charge.least = 0;
    charge.most = 100;
    config_.battery.source = BatterySource::kI2c;
    config_.battery.registers = {
        "/dev/i2c-1", 0x55, seconds(1), {charge, Register(0x08, "batt_volt", 2)}};
    Put(80, 0x3A98);
  }
  void Put(std::uint8_t percent, std::uint16_t voltage_mv) {
    i2c_.registers[0x2C] = {percent, 0};
    i2c_.registers[0x08] = {static_cast<std::uint8_t>(voltage_mv & 0xFFU),
                            static_cast<std::uint8_t>(voltage_mv >> 8U)};
  }
  std::vector<int> Charges() {
    std::vector<int> charges;
    for (const msg::BmsStatus& status : received_) charges.push_back(status.batt_soc);
    received_.clear();
    return charges;
  }

  std::vector<msg::BmsStatus> received_;
  std::unique_ptr<transport::Subscription> statuses_ =
      Listen<msg::BmsStatus>("dog1/bms_status", received_);
};

TEST_F(I2cBattery, IsPublishedByItsRegisters) {
  Start();
  Run(seconds(3));
  ASSERT_THAT(received_, SizeIs(::testing::Ge(2U)));
  EXPECT_EQ(received_.back().batt_soc, 80);
  EXPECT_EQ(received_.back().batt_volt, 15000);
  EXPECT_THAT(Failures(), IsEmpty());
}

// The policy would switch the robot off at 0 %.
TEST_F(I2cBattery, NeverPublishesOneWrongReading) {
  Start();
  Run(seconds(3));
  Put(0, 0);
  Run(seconds(1));
  Put(80, 0x3A98);
  Run(seconds(3));
  i2c_.fault = "the device does not acknowledge";
  Run(seconds(2));
  i2c_.fault = "";
  Put(255, 0xFFFF);  // a bus without a device
  Run(seconds(2));
  Put(79, 0x3A98);
  Run(seconds(3));
  EXPECT_THAT(Charges(), ::testing::Each(::testing::AnyOf(79, 80)));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(I2cBattery, SaysWhatIsWrongAndDoesNotRepeatItsLastReading) {
  Start();
  Run(seconds(3));
  Put(101, 0x3A98);
  Run(seconds(6));
  EXPECT_THAT(Failures(), ElementsAre(1409));
  EXPECT_THAT(log_, ::testing::Contains(HasSubstr(
                        "register 0x2C has 101 for 'batt_soc', which is from 0 up to 100 (1410)")));
  EXPECT_THAT(log_, ::testing::Contains(HasSubstr("no reading has counted for 5000 ms: register")));
  received_.clear();
  Run(seconds(10));
  EXPECT_THAT(Charges(), IsEmpty());
  Put(70, 0x3A98);
  Run(seconds(3));
  EXPECT_THAT(Charges(), ::testing::Contains(70));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(I2cBattery, IsReportedWhenItsBusIsGoneAndReadOnceItIsBack) {
  i2c_.fault = "No such file or directory; type: sudo modprobe i2c-dev && ls /dev/i2c-*";
  Start();
  Run(seconds(6));
  EXPECT_THAT(Failures(), ElementsAre(1409));
  EXPECT_THAT(log_.front(),
              HasSubstr("/dev/i2c-1: No such file or directory; type: sudo modprobe"));
  i2c_.fault = "";
  Run(seconds(3));
  EXPECT_THAT(Failures(), IsEmpty());
  EXPECT_THAT(Charges(), ::testing::Contains(80));
}

// The loop has everything else to do meanwhile, and no second call waits behind the first.
TEST_F(I2cBattery, NamesABusThatIsHeld) {
  Start();
  Run(seconds(3));
  i2c_.is_held = true;
  Run(seconds(7));
  EXPECT_THAT(Failures(), ElementsAre(1409));
  EXPECT_THAT(log_, ::testing::Contains(HasSubstr("ms: the bus is held")));
  i2c_.Release();
  Run(seconds(3));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(I2cBattery, EndsWhileItsBusIsHeld) {
  Start();
  i2c_.is_held = true;
  Run(seconds(2));
  devices_.reset();
  i2c_.Release();
  Run(seconds(2));
}

// --- sensors ---

class I2cSensor : public I2cDevices {
 protected:
  I2cSensor() {
    RegisterValue temperature = Register(0x00, "hall_temperature", 2);
    temperature.little_endian = false;
    temperature.zoom = 1.0 / 256;
    temperature.most = 100;
    temperature.jump = 10;
    config_.measurements = {{{"/dev/i2c-1", 0x48, seconds(1), {temperature}}, seconds(3)}};
    i2c_.registers[0x00] = {25, 128};
  }
  std::vector<float> Values() {
    std::vector<float> values;
    for (const msg::Float32& value : received_) values.push_back(value.data);
    received_.clear();
    return values;
  }

  std::vector<msg::Float32> received_;
  std::unique_ptr<transport::Subscription> values_ =
      Listen<msg::Float32>("dog1/measurement/hall_temperature", received_, transport::kLatchedQos);
};

TEST_F(I2cSensor, IsPublishedInTheUnitOfItsFile) {
  Start();
  Run(seconds(3));
  EXPECT_THAT(Values(), ::testing::Contains(25.5F));
  EXPECT_THAT(Failures(), IsEmpty());
}

TEST_F(I2cSensor, PublishesNoWrongValueAndHasNoPublisherWithoutOne) {
  Start();
  Run(seconds(3));
  received_.clear();
  i2c_.registers[0x00] = {90, 0};  // once
  Run(seconds(1));
  i2c_.registers[0x00] = {25, 0};
  Run(seconds(2));
  i2c_.registers[0x00] = {127, 255};
  Run(seconds(5));
  EXPECT_THAT(Values(), ::testing::Each(::testing::AnyOf(25.0F, 25.5F)));
  EXPECT_EQ(values_->MatchedWriters(), 0U);
  EXPECT_THAT(Failures(), ElementsAre(1009));
  i2c_.registers[0x00] = {26, 0};
  Run(seconds(4));
  EXPECT_THAT(Values(), ::testing::Contains(26.0F));
  EXPECT_EQ(values_->MatchedWriters(), 1U);
}

// --- Linux ---

TEST(I2cOfThisComputer, ThatDoesNotExistIsNamed) {
  const auto opened = OpenI2cFile("/dev/i2c-987", 0x55);
  ASSERT_FALSE(opened);
  EXPECT_EQ(
      opened.error().message,
      "/dev/i2c-987: No such file or directory; type: sudo modprobe i2c-dev && ls /dev/i2c-*");
  const auto no_bus = OpenI2cFile("/dev/null", 0x55);
  ASSERT_FALSE(no_bus);
  EXPECT_EQ(no_bus.error().message, "/dev/null is no I2C bus");
}

TEST(I2cOfThisComputer, ReadsOnAThread) {
  transport::LinuxEventLoop loop;
  std::vector<std::string> refused;
  I2cLink::Events events;
  events.on_refused = [&](const Error& error) { refused.push_back(error.message); };
  I2cProtocol protocol{"/dev/i2c-987", 0x55, seconds(1), {Register(0, "x", 1)}};
  I2cLink link(loop, I2cOfThisComputer(), protocol, seconds(60), std::move(events));
  EXPECT_THAT(refused, IsEmpty());
  EXPECT_TRUE(loop.RunUntil([&] { return !refused.empty(); }, musher::testing::In(seconds(120))));
  EXPECT_THAT(refused, ElementsAre(HasSubstr("/dev/i2c-987: ")));
}

// The bus of i2c-stub, a memory of registers for a device at this address.
constexpr std::uint8_t kStubAddress = 0x55;

std::string StubBus() {
  for (const auto& entry : EntriesOf("/sys/class/i2c-dev")) {
    if (ReadFile(entry / "name") == "SMBus stub driver\n") {
      return "/dev/" + entry.filename().string();
    }
  }
  return "";
}

// Writes a word, the lowest byte first.
void WriteStub(const std::string& bus, std::uint8_t address, std::uint16_t word) {
  const UniqueFd fd(open(bus.c_str(), O_RDWR | O_CLOEXEC));
  ASSERT_TRUE(fd.valid());
  ASSERT_EQ(ioctl(fd.get(), I2C_SLAVE_FORCE, static_cast<unsigned long>(kStubAddress)), 0);
  i2c_smbus_data data{};
  data.word = word;
  i2c_smbus_ioctl_data call{I2C_SMBUS_WRITE, address, I2C_SMBUS_WORD_DATA, &data};
  ASSERT_EQ(ioctl(fd.get(), I2C_SMBUS, &call), 0);
}

TEST(I2cOfThisComputer, ReadsTheRegistersOfAStub) {
  static_cast<void>(
      std::system("modprobe -q i2c-dev 2>/dev/null; modprobe -q i2c-stub "
                  "chip_addr=0x55 2>/dev/null"));
  const std::string bus = StubBus();
  if (bus.empty()) GTEST_SKIP() << "this kernel has no i2c-stub (chip_addr=0x55)";
  ASSERT_NO_FATAL_FAILURE(WriteStub(bus, 0x2C, 0x1234));
  ASSERT_NO_FATAL_FAILURE(WriteStub(bus, 0x10, 0x00AB));
  auto device = OpenI2cFile(bus, kStubAddress);
  ASSERT_TRUE(device) << device.error().message;
  EXPECT_THAT(device.value()->Read(0x2C, 2).value(), ElementsAre(0x34, 0x12));
  EXPECT_THAT(device.value()->Read(0x10, 1).value(), ElementsAre(0xAB));
  EXPECT_THAT(device.value()->Read(0x10, 4).value(), SizeIs(4));
  auto absent = OpenI2cFile(bus, 0x56);
  ASSERT_TRUE(absent) << absent.error().message;
  const auto bytes = absent.value()->Read(0x2C, 2);
  ASSERT_FALSE(bytes);
  EXPECT_THAT(bytes.error().message, HasSubstr(bus + " 0x56, register 0x2C: "));
}

}  // namespace musher::device::i2c_devices_test
