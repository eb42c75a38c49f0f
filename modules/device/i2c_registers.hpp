#pragma once
// What the registers of one device on an I2C bus mean, as data: values that are read period by
// period, and when one of them is believed. Plain values, no IO; i2c_registers_toml.hpp reads it
// from a file.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::device {

using RegisterBytes = std::vector<std::uint8_t>;  // in the order of the bus

// The number in a register, or in the bits `high` to `low` of it; times `zoom`, plus `offset`.
struct RegisterValue {
  std::string name;
  std::uint8_t address = 0;  // of the register
  std::size_t bytes = 1;     // 1, 2 or 4
  bool is_signed = false;
  bool little_endian = true;  // the first byte is the lowest one
  struct Bits {
    unsigned high = 0;
    unsigned low = 0;

    friend bool operator==(const Bits&, const Bits&) = default;
  };
  std::optional<Bits> bits;
  double zoom = 1;
  double offset = 0;
  std::optional<double> least;  // a value beyond them is refused
  std::optional<double> most;
  std::optional<double> jump;  // a value that is further from the last one waits for the next one
  Duration stuck_after{};      // the same number for longer is refused; 0: it may stay
  std::string unit;            // for messages

  friend bool operator==(const RegisterValue&, const RegisterValue&) = default;
};

struct I2cProtocol {
  std::string bus = "/dev/i2c-1";
  std::uint8_t address = 0;  // of the device
  Duration period = Milliseconds(1000);
  std::vector<RegisterValue> values;

  friend bool operator==(const I2cProtocol&, const I2cProtocol&) = default;
};

std::string HexadecimalByte(std::uint8_t byte);  // "0x0F"

// Fails with ParametersInvalid when it is not finite or out of its range. `bytes` has those of the
// register.
Result<double> DecodeRegister(const RegisterValue& value, const RegisterBytes& bytes);

// The values of a device, once they count: none is out of its range or stuck, and a jump is
// confirmed by the next reading. If one of them does not, no value of that reading counts.
class I2cRecord {
 public:
  using Values = std::map<std::string, double, std::less<>>;

  explicit I2cRecord(std::vector<RegisterValue> values);

  // The bytes of each register, in the order of the values. nullopt: a jump is held.
  Result<std::optional<Values>> Take(const std::vector<RegisterBytes>& registers, Time now);

  // Readings were missing: the next one is the first one.
  void Forget();

 private:
  // Of one value.
  struct Past {
    std::optional<double> last;    // that counted
    std::optional<double> before;  // of the last reading
    RegisterBytes bytes;
    std::optional<Time> same_since;
  };
  static bool Confirmed(const RegisterValue& value, Past& past, double found);

  const std::vector<RegisterValue> values_;
  std::vector<Past> past_;
};

}  // namespace musher::device
