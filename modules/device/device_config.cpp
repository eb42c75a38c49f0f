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
  if (source != BatterySource::kHost) {
    return WarnOfUnused(reader, "host", {"folder", "name", "period_ms"});
  }
  if (battery.silence > battery.period) return;
  reader.Fault(reader.At("silence_ms"), "silence_ms",
               "expected more than period_ms, or every reading comes too late");
}

// A file of frames that another one names: its own diagnostics, and its content.
class CanFiles {
 public:
  explicit CanFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::optional<CanProtocol> Read(const std::string& file, const CanNames& names) {
    auto parsed = ReadCanFile(config_toml::Absolute(folder_, file), names);
    std::ranges::move(parsed.diagnostics, std::back_inserter(diagnostics));
    return std::move(parsed.config);
  }

  std::vector<Diagnostic> diagnostics;

 private:
  const std::filesystem::path folder_;
};

Rows BatteryRows(BatteryConfig& battery, std::optional<BatterySource>& source,
                 const std::filesystem::path& folder, CanFiles& files) {
  const auto read_source = [&](TableReader& reader) {
    source = reader.Choice<BatterySource>("source", {{"world", BatterySource::kWorld},
                                                     {"host", BatterySource::kHost},
                                                     {"can", BatterySource::kCan},
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
  return {
      row::Required("source", "\"world\", \"host\", \"can\" or \"none\"", read_source),
      row::File("folder", battery.folder, folder),
      read_name,
      row::Time("period_ms", battery.period, kLeastPeriodMs),
      row::Time("silence_ms", battery.silence, kLeastPeriodMs),
      read_frames,
      [&](TableReader& reader) { CheckSource(reader, battery, source); },
  };
}

Row SourceOfKeys(KeySource& source) {
  return row::Required("source", "\"world\", \"input\" or \"none\"",
                       row::Choice("source", source,
                                   {{"world", KeySource::kWorld},
                                    {"input", KeySource::kInput},
                                    {"none", KeySource::kNone}}));
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

Rows TouchRows(TouchConfig& touch, const std::filesystem::path& folder) {
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
  };
}

Rows PowerKeyRows(PowerKeyConfig& key, const std::filesystem::path& folder) {
  return {
      SourceOfKeys(key.source),
      row::File("device", key.device, folder),
      row::Integer("key_code", key.code, 1, kHighestCode),
      row::Time("hold_ms", key.hold, kLeastPeriodMs),
      [&](TableReader& reader) { CheckInput(reader, key); },
  };
}

// The lights: names of LEDs, or files of frames.
Rows LedRows(LedConfig& led, const std::filesystem::path& folder, CanFiles& files) {
  constexpr std::array<std::string_view, kLedTargets.size()> kKeys = {"head", "tail", "mini"};
  const auto read_light = [&led, &files](TableReader& reader, std::string_view key, std::size_t i) {
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
      reader.Warn(word->at, key, "has no effect: only a source \"host\" or \"can\" uses it");
    }
    return true;
  };
  const auto read_lights = [&led, kKeys, read_light](TableReader& reader) {
    bool any = false;
    for (std::size_t i = 0; i < kKeys.size(); ++i) any |= read_light(reader, kKeys.at(i), i);
    if (led.source != LedSource::kHost) WarnOfUnused(reader, "host", {"folder"});
    const bool needs_one = led.source == LedSource::kHost || led.source == LedSource::kCan;
    if (any || !needs_one) return;
    reader.Fault(reader.At("source"), "source", "expected a key head, tail or mini beside it");
  };
  return {row::Required("source", "\"world\", \"host\", \"can\" or \"none\"",
                        row::Choice("source", led.source,
                                    {{"world", LedSource::kWorld},
                                     {"host", LedSource::kHost},
                                     {"can", LedSource::kCan},
                                     {"none", LedSource::kNone}})),
          row::File("folder", led.folder, folder), read_lights};
}

// Whether a device of the world exists.
Row WorldSource(bool& present) {
  return row::Required("source", "\"world\" or \"none\"",
                       row::Choice("source", present, {{"world", true}, {"none", false}}));
}

DeviceConfig Read(const Table& table, const std::string& path, Findings& findings,
                  CanFiles& files) {
  DeviceConfig config;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  const std::vector<std::string> none;
  std::optional<BatterySource> source;
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {row::Time("self_check_ms", config.self_check_time),
            DeviceNames("skip", config.skip, none, findings),
            DeviceNames("critical", config.critical, config.skip, findings),
            row::Required("battery", "a table [battery] with the source of its readings",
                          row::Sub("battery", BatteryRows(config.battery, source, folder, files))),
            row::Sub("touch", TouchRows(config.touch, folder)),
            row::Sub("led", LedRows(config.led, folder, files)),
            row::Sub("uwb", {WorldSource(config.uwb)}),
            row::Sub("power_key", PowerKeyRows(config.power_key, folder))});
  return config;
}

}  // namespace

Parsed<DeviceConfig> ReadDeviceText(std::string_view text, const std::string& path) {
  CanFiles files(config_toml::FolderOf(path));
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
