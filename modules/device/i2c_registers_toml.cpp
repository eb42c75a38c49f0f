#include "musher/modules/device/i2c_registers_toml.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::device {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

// Addresses of 7 bits without those that the bus reserves.
constexpr unsigned kFirstAddress = 0x08;
constexpr unsigned kLastAddress = 0x77;
constexpr unsigned kLastRegister = 0xFF;
constexpr std::int64_t kLeastI2cPeriodMs = 20;
constexpr double kLargestFactor = std::numeric_limits<float>::max();

std::optional<unsigned> HexadecimalOf(const std::string& text) {
  if (!text.starts_with("0x") && !text.starts_with("0X")) return std::nullopt;
  unsigned value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data() + 2, end, value, 16);
  if (fault != std::errc() || rest != end) return std::nullopt;
  return value;
}

Row Hexadecimal(std::string_view key, std::uint8_t& value, unsigned least, unsigned most,
                std::string_view expected) {
  const auto read = [=, &value](TableReader& reader) {
    const auto word = reader.String(key);
    if (!word) return;
    const auto number = HexadecimalOf(word->text);
    if (number && *number >= least && *number <= most) {
      value = static_cast<std::uint8_t>(*number);
    } else {
      reader.Fault(word->at, key,
                   "expected a hexadecimal number from " +
                       HexadecimalByte(static_cast<std::uint8_t>(least)) + " to " +
                       HexadecimalByte(static_cast<std::uint8_t>(most)) + ", found " +
                       config_toml::Quote(word->text));
    }
  };
  return row::Required(key, expected, read);
}

Row OptionalNumber(std::string_view key, std::optional<double>& value, double least) {
  return [=, &value](TableReader& reader) {
    if (const auto found = reader.Number(key, least, kLargestFactor)) value = found;
  };
}

struct RegisterType {
  std::size_t bytes;
  bool is_signed;
};

class RegisterReader {
 public:
  RegisterReader(const RegisterNames& names, Findings& findings)
      : names_(names), findings_(findings) {}

  I2cProtocol Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    bool is_i2c = true;
    std::string ignored;
    ReadRows(root, {row::Choice("protocol", is_i2c, {{"i2c", true}}), row::Text("name", ignored),
                    row::Required("bus", "the file of the bus, \"/dev/i2c-1\"",
                                  row::Text("bus", protocol_.bus)),
                    Hexadecimal("address", protocol_.address, kFirstAddress, kLastAddress,
                                "the address of the device, such as \"0x55\""),
                    row::Time("period_ms", protocol_.period, kLeastI2cPeriodMs),
                    [this](TableReader& reader) { ReadValues(reader); }});
    return std::move(protocol_);
  }

 private:
  void ReadValues(TableReader& root) {
    std::vector<std::string> taken;
    for (TableReader& reader : root.Subs("var")) {
      protocol_.values.push_back(ReadValue(reader, taken));
    }
    const bool is_needed = !names_.needed.empty();
    if (is_needed && std::ranges::find(taken, names_.needed) == taken.end()) {
      root.Fault(root.At("var"), "var", "there is no " + config_toml::Quote(names_.needed));
    } else if (protocol_.values.empty()) {
      root.Fault(root.At("var"), "var", "expected a [[var]] for each value");
    }
  }

  RegisterValue ReadValue(TableReader& reader, std::vector<std::string>& taken) {
    RegisterValue value;
    RegisterType type{1, false};
    std::optional<bool> little;
    const auto read_order = [&](TableReader& table) {
      little = table.Choice<bool>("byte_order", {{"little", true}, {"big", false}});
    };
    ReadRows(
        reader,
        {Hexadecimal("register", value.address, 0, kLastRegister,
                     "the number of the register, such as \"0x2C\""),
         Name(value.name, taken),
         row::Required("var_type", "\"u8\", \"i16\" …",
                       row::Choice("var_type", type,
                                   {{"u8", {1, false}},
                                    {"u16", {2, false}},
                                    {"u32", {4, false}},
                                    {"i8", {1, true}},
                                    {"i16", {2, true}},
                                    {"i32", {4, true}}})),
         read_order,
         [&](TableReader& table) {
           if (type.bytes > 1) table.Require("byte_order", "\"little\" or \"big\"");
         },
         [&](TableReader& table) { ReadBits(table, value, type); },
         row::Number("var_zoom", value.zoom, -kLargestFactor, kLargestFactor),
         row::Number("offset", value.offset, -kLargestFactor, kLargestFactor),
         OptionalNumber("least", value.least, -kLargestFactor),
         OptionalNumber("most", value.most, -kLargestFactor),
         row::Check(
             "most", [&] { return !value.least || !value.most || *value.least <= *value.most; },
             "expected least or more"),
         OptionalNumber("jump", value.jump, 0), row::Time("stuck_after_ms", value.stuck_after),
         row::Check(
             "stuck_after_ms",
             [&] {
               return value.stuck_after == Duration() || value.stuck_after > protocol_.period;
             },
             "expected more than period_ms"),
         row::Text("unit", value.unit)});
    value.bytes = type.bytes;
    value.is_signed = type.is_signed;
    value.little_endian = little.value_or(true);
    return value;
  }

  // One of those that the device knows, or the name of a topic; and no second time.
  Row Name(std::string& name, std::vector<std::string>& taken) {
    const auto read = [this, &name, &taken](TableReader& reader) {
      const auto word = names_.known.empty() ? reader.Topic("var_name", "battery_cell",
                                                            {.of = "a value", .relative = true})
                                             : reader.String("var_name");
      if (!word) return;
      name = word->text;
      const auto& known = names_.known;
      if (!known.empty() && std::ranges::find(known, name) == known.end()) {
        reader.Fault(word->at, "var_name",
                     "expected one of " + config_toml::Listing(known) + ", found " +
                         config_toml::Quote(name) + findings_.Guess(name, known));
      } else if (std::ranges::find(taken, name) != taken.end()) {
        reader.Fault(word->at, "var_name", config_toml::Quote(name) + " is defined above already");
      }
      taken.push_back(name);
    };
    return row::Required("var_name", "the name of what the register has", read);
  }

  static void ReadBits(TableReader& reader, RegisterValue& value, const RegisterType& type) {
    const auto last = static_cast<std::int64_t>(type.bytes) * 8 - 1;
    const auto bits = reader.Integers("bits", 0, last);
    if (!bits || reader.IsFaulty("bits")) return;
    const auto fault = [&](std::string_view message) {
      reader.Fault(reader.At("bits"), "bits", message);
    };
    if (bits->size() != 2 || bits->at(0) < bits->at(1)) return fault("expected [high, low]");
    if (type.is_signed) return fault("bits are of type u8, u16 or u32");
    value.bits = {static_cast<unsigned>(bits->at(0)), static_cast<unsigned>(bits->at(1))};
  }

  const RegisterNames& names_;
  Findings& findings_;
  I2cProtocol protocol_;
};

}  // namespace

Parsed<I2cProtocol> ReadI2cText(std::string_view text, const std::string& path,
                                const RegisterNames& names) {
  return config_toml::ReadTextWith<Parsed<I2cProtocol>>(
      text, path, [&](const Table& root, Findings& findings) {
        return RegisterReader(names, findings).Read(root);
      });
}

Parsed<I2cProtocol> ReadI2cFile(const std::string& path, const RegisterNames& names) {
  return config_toml::ReadFileWith(path, [&](std::string_view text, const std::string& file) {
    return ReadI2cText(text, file, names);
  });
}

}  // namespace musher::device
