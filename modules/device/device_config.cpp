#include "musher/modules/device/device_config.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <optional>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/modules/device/can_battery.hpp"
#include "musher/modules/device/i2c_registers_toml.hpp"
#include "musher/modules/device/self_check.hpp"

namespace musher::device {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr std::int64_t kLeastPeriodMs = 100;

// The names of devices; `skip` is empty, or the devices that are skipped.
Row DeviceNames(std::string_view key, std::vector<std::string>& devices,
                const std::vector<std::string>& skip, Findings& findings) {
  return [&, key](TableReader& root) {
    const auto words = root.Strings(key, {.may_be_empty = true});
    if (!words) return;
    const std::vector<std::string_view> known(kDevices.begin(), kDevices.end());
    devices.clear();
    for (const Word& word : *words) {
      devices.push_back(word.text);
      if (std::find(known.begin(), known.end(), word.text) != known.end()) continue;
      root.Fault(word.at, key,
                 "expected one of " + config_toml::Listing(known) + ", found " +
                     config_toml::Quote(word.text) + findings.Guess(word.text, known));
    }
    for (const Word& word : *words) {
      if (std::find(skip.begin(), skip.end(), word.text) != skip.end()) {
        root.Fault(word.at, key, "a device that is skipped cannot be critical");
      }
    }
  };
}

// Keys that only a source of that name uses.
void WarnOfUnused(TableReader& reader, std::string_view source,
                  std::initializer_list<std::string_view> keys) {
  for (const std::string_view key : keys) {
    if (!reader.Has(key)) continue;
    reader.Warn(reader.At(key), key,
                "has no effect: only a source " + config_toml::Quote(source) + " uses it");
  }
}

// What only some sources use.
void CheckSource(TableReader& reader, const BatteryConfig& battery,
                 std::optional<BatterySource> source) {
  if (!source) return;
  if (source == BatterySource::kCan) {
    reader.Require("frames", "the file of the battery's frames");
  } else {
    WarnOfUnused(reader, "can", {"frames"});
  }
  if (source == BatterySource::kI2c) {
    reader.Require("registers", "the file of the battery's registers");
    if (battery.silence <= battery.registers.period) {
      reader.Fault(
          reader.At("silence_ms"), "silence_ms",
          "expected more than period_ms of its registers, or every reading comes too late");
    }
  } else {
    WarnOfUnused(reader, "i2c", {"registers"});
  }
  if (source != BatterySource::kHost) {
    return WarnOfUnused(reader, "host", {"folder", "name", "period_ms"});
  }
  if (battery.silence > battery.period) return;
  reader.Fault(reader.At("silence_ms"), "silence_ms",
               "expected more than period_ms, or every reading comes too late");
}

// Files of frames or registers that another file names: their own diagnostics, and their content.
class BusFiles {
 public:
  explicit BusFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<CanProtocol> Read(const std::string& file, const CanNames& names) {
    return Take(ReadCanFile(config_toml::Absolute(folder_, file), names));
  }
  std::optional<I2cProtocol> Read(const std::string& file, const RegisterNames& names) {
    return Take(ReadI2cFile(config_toml::Absolute(folder_, file), names));
  }

  std::vector<Diagnostic> diagnostics;

 private:
  template <typename T>
  std::optional<T> Take(Parsed<T> parsed) {
    std::ranges::move(parsed.diagnostics, std::back_inserter(diagnostics));
    return std::move(parsed.config);
  }

  const std::filesystem::path folder_;
};

Rows BatteryRows(BatteryConfig& battery, std::optional<BatterySource>& source,
                 const std::filesystem::path& folder, BusFiles& files) {
  const auto read_source = [&](TableReader& reader) {
    source = reader.Choice<BatterySource>("source", {{"world", BatterySource::kWorld},
                                                     {"host", BatterySource::kHost},
                                                     {"can", BatterySource::kCan},
                                                     {"i2c", BatterySource::kI2c},
                                                     {"none", BatterySource::kNone}});
    battery.source = source.value_or(battery.source);
  };
  const auto read_name = [&](TableReader& reader) {
    const auto name = reader.String("name");
    if (!name) return;
    battery.name = name->text;
    if (name->text.find('/') != std::string::npos) {
      reader.Fault(name->at, "name", "expected the name of a supply, found a path");
    }
  };
  const auto read_frames = [&](TableReader& reader) {
    const auto file = reader.String("frames");
    if (!file || source != BatterySource::kCan) return;
    if (auto frames = files.Read(file->text, BatteryCanNames())) {
      battery.frames = *std::move(frames);
    }
  };
  const auto read_registers = [&](TableReader& reader) {
    const auto file = reader.String("registers");
    if (!file || source != BatterySource::kI2c) return;
    const RegisterNames names{BatteryCanNames().fields, BatteryCanNames().needed_field};
    if (auto registers = files.Read(file->text, names)) battery.registers = *std::move(registers);
  };
  return {
      row::Required("source", "\"world\", \"host\", \"can\", \"i2c\" or \"none\"", read_source),
      row::File("folder", battery.folder, folder),
      read_name,
      row::Time("period_ms", battery.period, kLeastPeriodMs),
      row::Time("silence_ms", battery.silence, kLeastPeriodMs),
      read_frames,
      read_registers,
      [&](TableReader& reader) { CheckSource(reader, battery, source); },
  };
}

Row SourceOfKeys(KeySource& source) {
  return row::Required("source", "\"world\", \"input\", \"gpio\" or \"none\"",
                       row::Choice("source", source,
                                   {{"world", KeySource::kWorld},
                                    {"input", KeySource::kInput},
                                    {"gpio", KeySource::kGpio},
                                    {"none", KeySource::kNone}}));
}

// The names of the GPIO lines of a file: a line has one user.
using UsedLines = std::vector<std::string>;

void UseLine(TableReader& reader, std::string_view key, UsedLines& used, GpioSpec& spec) {
  const auto word = reader.String(key);
  if (!word) return;
  spec.line = word->text;
  if (spec.line.empty()) {
    reader.Fault(word->at, key, "expected the name of a GPIO line, or \"gpiochip0:5\"");
  } else if (std::ranges::find(used, spec.line) != used.end()) {
    reader.Fault(word->at, key,
                 "the line " + config_toml::Quote(spec.line) + " is used above already");
  }
  used.push_back(spec.line);
}

// Of an input. `is_used`: whether the device is on it; else its keys have no effect.
Row InputLine(GpioSpec& spec, UsedLines& used, std::function<bool()> is_used) {
  return [&spec, &used, is_used = std::move(is_used)](TableReader& reader) {
    if (!is_used())
      return WarnOfUnused(reader, "gpio", {"line", "active_low", "bias", "debounce_ms"});
    reader.Require("line", "the name of a GPIO line, or \"gpiochip0:5\"");
    UseLine(reader, "line", used, spec);
    spec.active_low = reader.Bool("active_low").value_or(spec.active_low);
    spec.bias = reader
                    .Choice<GpioBias>("bias", {{"as-is", GpioBias::kAsIs},
                                               {"pull-up", GpioBias::kPullUp},
                                               {"pull-down", GpioBias::kPullDown},
                                               {"none", GpioBias::kNone}})
                    .value_or(spec.bias);
    constexpr std::int64_t kMostDebounceMs = 1000;
    const auto debounce = reader.Integer("debounce_ms", 0, kMostDebounceMs, "ms");
    if (debounce) spec.debounce = Milliseconds(*debounce);
  };
}

// What only a source "input" uses.
void CheckInput(TableReader& reader, const PowerKeyConfig& key) {
  const bool is_input = key.source == KeySource::kInput;
  if (is_input) reader.Require("device", "the file of an input device, \"/dev/input/event0\"");
  if (!is_input) WarnOfUnused(reader, "input", {"device", "key_code"});
}

// The same of a touch pad.
void CheckTouch(TableReader& reader, const TouchConfig& touch) {
  const bool is_input = touch.source == KeySource::kInput;
  const bool has_both = reader.Has("device") && reader.Has("device_name");
  if (is_input && has_both) {
    reader.Fault(reader.At("device_name"), "device_name",
                 "expected either device or device_name, found both");
  } else if (is_input && !reader.Has("device_name")) {
    reader.Require("device", "the file of an input device, \"/dev/input/event0\", or device_name");
  }
  if (!is_input) WarnOfUnused(reader, "input", {"device", "device_name", "codes"});
  if (touch.codes == TouchCodes{}) {
    reader.Fault(reader.At("codes"), "codes",
                 "expected the number of a key for tap, single, double or hold");
  }
}

constexpr std::int64_t kHighestCode = 767;  // KEY_MAX of the kernel

Rows TouchRows(TouchConfig& touch, const std::filesystem::path& folder, UsedLines& lines) {
  TouchCodes& codes = touch.codes;
  return {
      SourceOfKeys(touch.source),
      row::File("device", touch.input.file, folder),
      row::Text("device_name", touch.input.name),
      [&codes](TableReader& reader) {
        if (reader.Has("codes")) codes = {};
      },
      row::Sub("codes", {row::Integer("tap", codes.tap, 1, kHighestCode),
                         row::Integer("single", codes.single, 1, kHighestCode),
                         row::Integer("double", codes.double_tap, 1, kHighestCode),
                         row::Integer("hold", codes.hold, 1, kHighestCode)}),
      [&touch](TableReader& reader) { CheckTouch(reader, touch); },
      InputLine(touch.line, lines, [&touch] { return touch.source == KeySource::kGpio; }),
  };
}

Rows PowerKeyRows(PowerKeyConfig& key, const std::filesystem::path& folder, UsedLines& lines) {
  return {
      SourceOfKeys(key.source),
      row::File("device", key.device, folder),
      row::Integer("key_code", key.code, 1, kHighestCode),
      row::Time("hold_ms", key.hold, kLeastPeriodMs),
      [&](TableReader& reader) { CheckInput(reader, key); },
      InputLine(key.line, lines, [&key] { return key.source == KeySource::kGpio; }),
  };
}

// The lights: names of LEDs or lines, or files of frames.
Rows LedRows(LedConfig& led, const std::filesystem::path& folder, BusFiles& files,
             UsedLines& lines) {
  constexpr std::array<std::string_view, kLedTargets.size()> kKeys = {"head", "tail", "mini"};
  const auto read_light = [&led, &files, &lines](TableReader& reader, std::string_view key,
                                                 std::size_t i) {
    if (led.source == LedSource::kGpio) {
      UseLine(reader, key, lines, led.lines.at(i));
      return reader.Has(key);
    }
    const auto word = reader.String(key);
    if (!word) return false;
    if (led.source == LedSource::kCan) {
      led.frames.at(i) = files.Read(word->text, LightCanNames());
    } else if (led.source == LedSource::kHost) {
      led.names.at(i) = word->text;
      if (word->text.empty() || word->text.find('/') != std::string::npos) {
        reader.Fault(word->at, key, "expected the name of an LED, found a path");
      }
    } else {
      reader.Warn(word->at, key,
                  "has no effect: only a source \"host\", \"can\" or \"gpio\" uses it");
    }
    return true;
  };
  const auto read_lights = [&led, kKeys, read_light](TableReader& reader) {
    bool any = false;
    for (std::size_t i = 0; i < kKeys.size(); ++i) any |= read_light(reader, kKeys.at(i), i);
    if (led.source != LedSource::kHost) WarnOfUnused(reader, "host", {"folder"});
    if (led.source == LedSource::kGpio) {
      const bool active_low = reader.Bool("active_low").value_or(false);
      for (GpioSpec& line : led.lines) line.active_low = active_low;
    } else {
      WarnOfUnused(reader, "gpio", {"active_low"});
    }
    const bool needs_one = led.source != LedSource::kWorld && led.source != LedSource::kNone;
    if (any || !needs_one) return;
    reader.Fault(reader.At("source"), "source", "expected a key head, tail or mini beside it");
  };
  return {row::Required("source", "\"world\", \"host\", \"can\", \"gpio\" or \"none\"",
                        row::Choice("source", led.source,
                                    {{"world", LedSource::kWorld},
                                     {"host", LedSource::kHost},
                                     {"can", LedSource::kCan},
                                     {"gpio", LedSource::kGpio},
                                     {"none", LedSource::kNone}})),
          row::File("folder", led.folder, folder), read_lights};
}

// Whether a device of the world exists.
Row WorldSource(bool& present) {
  return row::Required("source", "\"world\" or \"none\"",
                       row::Choice("source", present, {{"world", true}, {"none", false}}));
}

// A name of a topic; and no second time.
Row ContactName(std::string& name, std::vector<std::string>& taken) {
  const auto read = [&name, &taken](TableReader& reader) {
    const auto word = reader.Topic("name", "bumper_left", {.of = "a contact", .relative = true});
    if (!word) return;
    name = word->text;
    if (std::ranges::find(taken, name) != taken.end()) {
      reader.Fault(word->at, "name", config_toml::Quote(name) + " is defined above already");
    }
    taken.push_back(name);
  };
  return row::Required("name", "the name of the contact, which its topic has", read);
}

void ReadContacts(TableReader& root, std::vector<ContactConfig>& contacts, UsedLines& lines) {
  std::vector<std::string> taken;
  for (TableReader& reader : root.Subs("contact")) {
    ContactConfig contact;
    ReadRows(reader, {ContactName(contact.name, taken),
                      InputLine(contact.line, lines, [] { return true; })});
    contacts.push_back(std::move(contact));
  }
}

void ReadMeasurements(TableReader& root, std::vector<MeasurementConfig>& measurements,
                      BusFiles& files) {
  std::vector<std::string> taken;
  for (TableReader& reader : root.Subs("measurement")) {
    MeasurementConfig measurement;
    const auto read_registers = [&](TableReader& table) {
      const auto file = table.String("registers");
      if (!file) return;
      if (auto found = files.Read(file->text, RegisterNames{})) {
        measurement.registers = *std::move(found);
      }
      for (const RegisterValue& value : measurement.registers.values) {
        if (std::ranges::find(taken, value.name) != taken.end()) {
          table.Fault(file->at, "registers",
                      "its value " + config_toml::Quote(value.name) + " is defined above already");
        }
        taken.push_back(value.name);
      }
    };
    ReadRows(reader,
             {row::Required("registers", "the file of the sensor's registers", read_registers),
              row::Time("silence_ms", measurement.silence, kLeastPeriodMs),
              row::Check(
                  "silence_ms", [&] { return measurement.silence > measurement.registers.period; },
                  "expected more than period_ms of its registers")});
    measurements.push_back(std::move(measurement));
  }
}

DeviceConfig Read(const Table& table, const std::string& path, Findings& findings,
                  BusFiles& files) {
  DeviceConfig config;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  const std::vector<std::string> none;
  std::optional<BatterySource> source;
  UsedLines lines;
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {row::Time("self_check_ms", config.self_check_time),
            DeviceNames("skip", config.skip, none, findings),
            DeviceNames("critical", config.critical, config.skip, findings),
            row::Required("battery", "a table [battery] with the source of its readings",
                          row::Sub("battery", BatteryRows(config.battery, source, folder, files))),
            row::Sub("touch", TouchRows(config.touch, folder, lines)),
            row::Sub("led", LedRows(config.led, folder, files, lines)),
            row::Sub("uwb", {WorldSource(config.uwb)}),
            row::Sub("power_key", PowerKeyRows(config.power_key, folder, lines)),
            [&](TableReader& reader) { ReadContacts(reader, config.contacts, lines); },
            [&](TableReader& reader) { ReadMeasurements(reader, config.measurements, files); }});
  return config;
}

}  // namespace

Parsed<DeviceConfig> ReadDeviceText(std::string_view text, const std::string& path) {
  BusFiles files(config_toml::FolderOf(path));
  auto parsed = config_toml::ReadTextWith<Parsed<DeviceConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings, files); });
  for (Diagnostic& one : files.diagnostics) {
    if (one.severity == Severity::kError) parsed.config.reset();
    parsed.diagnostics.push_back(std::move(one));
  }
  return parsed;
}

Parsed<DeviceConfig> ReadDeviceFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadDeviceText);
}

}  // namespace musher::device
