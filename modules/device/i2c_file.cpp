#include "musher/modules/device/i2c_file.hpp"

#include <fcntl.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "musher/base/unique_fd.hpp"

namespace musher::device {
namespace {

Error I2cError(const std::string& what) {
  return {static_cast<std::int32_t>(KeyCode::kNetError), what};
}

Error NoBus(const std::string& bus, int why) {
  std::string text = bus + ": " + std::strerror(why);
  if (why == ENOENT) text += "; type: sudo modprobe i2c-dev && ls /dev/i2c-*";
  if (why == EACCES || why == EPERM) {
    text += "; add the account of the robot to the group of that file: ls -l " + bus;
  }
  return I2cError(text);
}

class I2cFile : public I2cBus {
 public:
  I2cFile(UniqueFd fd, std::string name, unsigned long functions)
      : fd_(std::move(fd)), name_(std::move(name)), functions_(functions) {}

  Result<RegisterBytes> Read(std::uint8_t address, std::size_t bytes) override {
    const auto [size, needed] = CallOf(bytes);
    if ((functions_ & needed) != needed) {
      return I2cError(name_ + ": its bus cannot read " + std::to_string(bytes) + " bytes at once");
    }
    i2c_smbus_data data{};
    data.block[0] = static_cast<std::uint8_t>(bytes);
    i2c_smbus_ioctl_data call{I2C_SMBUS_READ, address, size, &data};
    if (ioctl(fd_.get(), I2C_SMBUS, &call) != 0) return Failed(address, errno);
    if (bytes == 1) return RegisterBytes{data.byte};
    if (bytes == 2) {  // the kernel takes the first byte for the lowest one
      return RegisterBytes{static_cast<std::uint8_t>(data.word & 0xFFU),
                           static_cast<std::uint8_t>(data.word >> 8U)};
    }
    if (data.block[0] != bytes) return Failed(address, EPROTO);
    return RegisterBytes(data.block + 1, data.block + 1 + bytes);
  }

 private:
  struct Call {
    std::uint32_t size;
    unsigned long needed;
  };
  static Call CallOf(std::size_t bytes) {
    if (bytes == 1) return {I2C_SMBUS_BYTE_DATA, I2C_FUNC_SMBUS_READ_BYTE_DATA};
    if (bytes == 2) return {I2C_SMBUS_WORD_DATA, I2C_FUNC_SMBUS_READ_WORD_DATA};
    return {I2C_SMBUS_I2C_BLOCK_DATA, I2C_FUNC_SMBUS_READ_I2C_BLOCK};
  }
  Error Failed(std::uint8_t address, int why) const {
    std::string text = name_ + ", register " + HexadecimalByte(address) + ": ";
    switch (why) {
      case ENXIO:
      case EREMOTEIO:
        text += "the device does not acknowledge: look at its address, power and cable";
        break;
      case ETIMEDOUT:
      case EAGAIN:
        text += "the bus is held: look at its pull-up resistors, and for a device without power";
        break;
      case ENODEV:
        text += "there is no such device, or its bus is gone";
        break;
      default:
        text += std::strerror(why);
    }
    return I2cError(text);
  }

  const UniqueFd fd_;
  const std::string name_;
  const unsigned long functions_;
};

}  // namespace

Result<std::unique_ptr<I2cBus>> OpenI2cFile(const std::string& bus, std::uint8_t address) {
  UniqueFd fd(open(bus.c_str(), O_RDWR | O_CLOEXEC));
  if (!fd.valid()) return NoBus(bus, errno);
  unsigned long functions = 0;
  if (ioctl(fd.get(), I2C_FUNCS, &functions) != 0) return I2cError(bus + " is no I2C bus");
  const std::string name = bus + " " + HexadecimalByte(address);
  if (ioctl(fd.get(), I2C_SLAVE, static_cast<unsigned long>(address)) != 0) {
    const bool is_used = errno == EBUSY;
    return I2cError(name + ": " + std::strerror(errno) +
                    (is_used ? "; a driver of the kernel uses it: take what that offers, such as "
                               "a battery in /sys/class/power_supply"
                             : ""));
  }
  return std::unique_ptr<I2cBus>(std::make_unique<I2cFile>(std::move(fd), name, functions));
}

}  // namespace musher::device
