#include "musher/modules/device/i2c_registers.hpp"

#include <cmath>
#include <sstream>
#include <utility>

#include "musher/base/check.hpp"

namespace musher::device {
namespace {

constexpr unsigned kBitsOfAByte = 8;

std::string WithUnit(double number, const RegisterValue& value) {
  std::ostringstream text;
  text << number;
  return text.str() + (value.unit.empty() ? "" : " " + value.unit);
}

Error InvalidRegister(const RegisterValue& value, const std::string& what) {
  return {static_cast<std::int32_t>(KeyCode::kParametersInvalid),
          "register " + HexadecimalByte(value.address) + " " + what};
}

double RegisterNumber(const RegisterValue& value, const RegisterBytes& bytes) {
  std::uint64_t raw = 0;
  for (std::size_t i = 0; i < value.bytes; ++i) {
    raw = raw << kBitsOfAByte | bytes.at(value.little_endian ? value.bytes - 1 - i : i);
  }
  if (value.bits) {
    const unsigned width = value.bits->high - value.bits->low + 1;
    return static_cast<double>(raw >> value.bits->low & ((std::uint64_t{1} << width) - 1));
  }
  if (!value.is_signed) return static_cast<double>(raw);
  const auto unused = static_cast<unsigned>(sizeof raw - value.bytes) * kBitsOfAByte;
  return static_cast<double>(static_cast<std::int64_t>(raw << unused) >> unused);
}

}  // namespace

std::string HexadecimalByte(std::uint8_t byte) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  return {'0', 'x', kDigits.at(byte >> 4U), kDigits.at(byte & 0xFU)};
}

Result<double> DecodeRegister(const RegisterValue& value, const RegisterBytes& bytes) {
  MUSHER_CHECK(bytes.size() == value.bytes);
  const double number = RegisterNumber(value, bytes) * value.zoom + value.offset;
  if (!std::isfinite(number)) {
    return InvalidRegister(value, "has a '" + value.name + "' that is no number");
  }
  if ((value.least && number < *value.least) || (value.most && number > *value.most)) {
    const std::string least = value.least ? "from " + WithUnit(*value.least, value) : "";
    const std::string most = value.most ? "up to " + WithUnit(*value.most, value) : "";
    return InvalidRegister(value, "has " + WithUnit(number, value) + " for '" + value.name +
                                      "', which is " + least +
                                      (value.least && value.most ? " " : "") + most);
  }
  return number;
}

I2cRecord::I2cRecord(std::vector<RegisterValue> values)
    : values_(std::move(values)), past_(values_.size()) {}

Result<std::optional<I2cRecord::Values>> I2cRecord::Take(
    const std::vector<RegisterBytes>& registers, Time now) {
  MUSHER_CHECK(registers.size() == values_.size());
  std::vector<double> found;
  std::optional<Error> refused;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const RegisterValue& value = values_.at(i);
    Past& past = past_.at(i);
    if (!past.same_since || past.bytes != registers.at(i)) past.same_since = now;
    past.bytes = registers.at(i);
    const auto number = DecodeRegister(value, registers.at(i));
    if (!number) {
      refused = refused ? refused : number.error();
      continue;
    }
    const Duration same = now - *past.same_since;
    if (value.stuck_after > Duration() && same >= value.stuck_after) {
      refused = InvalidRegister(
          value, "has had " + WithUnit(number.value(), value) + " for '" + value.name + "' for " +
                     std::to_string(ToMilliseconds(same)) + " ms: the device is stuck");
    }
    found.push_back(number.value());
  }
  if (refused) return *refused;
  bool all = true;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    all = Confirmed(values_.at(i), past_.at(i), found.at(i)) && all;
  }
  if (!all) return std::optional<Values>();
  Values record;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    record[values_.at(i).name] = found.at(i);
    past_.at(i).last = found.at(i);
  }
  return std::optional<Values>(std::move(record));
}

// The first one is held, too: a device may not have measured yet. Compared with the reading before,
// whether that counted or not: another value of it may have been held.
bool I2cRecord::Confirmed(const RegisterValue& value, Past& past, double found) {
  const auto before = std::exchange(past.before, found);
  if (!value.jump) return true;
  const auto is_near = [&](const std::optional<double>& other) {
    return other && std::abs(found - *other) <= *value.jump;
  };
  return is_near(past.last) || is_near(before);
}

void I2cRecord::Forget() {
  past_.assign(values_.size(), {});
}

}  // namespace musher::device
