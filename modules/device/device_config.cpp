#include "musher/modules/device/device_config.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/device/self_check.hpp"

namespace musher::device {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr std::int64_t kLeastPeriodMs = 100;

class Reader {
 public:
  Reader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {}

  DeviceConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    config_.self_check_time = root.Time("self_check_ms").value_or(config_.self_check_time);
    config_.skip = Devices(root, "skip");
    config_.critical = Devices(root, "critical");
    root.Require("battery", "a table [battery] with the source of its readings");
    if (const Table* battery = root.SubTable("battery")) {
      TableReader reader(*battery, root.At("battery"), "battery", findings_);
      ReadBattery(reader);
      reader.RefuseOthers();
    }
    config_.touch = IsOfWorld(root, "touch");
    config_.led = IsOfWorld(root, "led");
    config_.uwb = IsOfWorld(root, "uwb");
    ReadPowerKey(root);
    root.RefuseOthers();
    return std::move(config_);
  }

 private:
  std::vector<std::string> Devices(TableReader& root, std::string_view key) {
    const auto words = root.Strings(key, {.may_be_empty = true});
    std::vector<std::string> devices;
    if (!words) return devices;
    const std::vector<std::string_view> known(kDevices.begin(), kDevices.end());
    for (const Word& word : *words) {
      devices.push_back(word.text);
      if (std::find(known.begin(), known.end(), word.text) != known.end()) continue;
      root.Fault(word.at, key,
                 "expected one of " + config_toml::Listing(known) + ", found " +
                     config_toml::Quote(word.text) + findings_.Guess(word.text, known));
    }
    for (const Word& word : *words) {
      const auto& skip = config_.skip;
      if (key == "critical" && std::find(skip.begin(), skip.end(), word.text) != skip.end()) {
        root.Fault(word.at, key, "a device that is skipped cannot be critical");
      }
    }
    return devices;
  }

  void ReadBattery(TableReader& reader) {
    BatteryConfig& battery = config_.battery;
    reader.Require("source", "\"world\", \"host\" or \"none\"");
    const auto source = reader.Choice<BatterySource>("source", {{"world", BatterySource::kWorld},
                                                                {"host", BatterySource::kHost},
                                                                {"none", BatterySource::kNone}});
    battery.source = source.value_or(battery.source);
    if (const auto folder = reader.String("folder")) {
      battery.folder = config_toml::Absolute(folder_, folder->text);
    }
    if (const auto name = reader.String("name")) {
      battery.name = name->text;
      if (name->text.find('/') != std::string::npos) {
        reader.Fault(name->at, "name", "expected the name of a supply, found a path");
      }
    }
    battery.period = reader.Time("period_ms", kLeastPeriodMs).value_or(battery.period);
    battery.silence = reader.Time("silence_ms", kLeastPeriodMs).value_or(battery.silence);
    if (source == BatterySource::kHost) {
      if (battery.silence <= battery.period) {
        reader.Fault(reader.At("silence_ms"), "silence_ms",
                     "expected more than period_ms, or every reading comes too late");
      }
      return;
    }
    for (const std::string_view key : {"folder", "name", "period_ms"}) {
      if (source && reader.Has(key)) {
        reader.Warn(reader.At(key), key, "has no effect: only a source \"host\" uses it");
      }
    }
  }

  // Whether that device exists.
  bool IsOfWorld(TableReader& root, std::string_view device) {
    const Table* table = root.SubTable(device);
    if (table == nullptr) return false;
    TableReader reader(*table, root.At(device), std::string(device), findings_);
    const bool world = ReadWorldSource(reader);
    reader.RefuseOthers();
    return world;
  }

  static bool ReadWorldSource(TableReader& reader) {
    reader.Require("source", "\"world\" or \"none\"");
    return reader.Choice<bool>("source", {{"world", true}, {"none", false}}).value_or(false);
  }

  void ReadPowerKey(TableReader& root) {
    const Table* table = root.SubTable("power_key");
    if (table == nullptr) return;
    TableReader reader(*table, root.At("power_key"), "power_key", findings_);
    PowerKeyConfig& key = config_.power_key;
    key.present = ReadWorldSource(reader);
    key.hold = reader.Time("hold_ms", kLeastPeriodMs).value_or(key.hold);
    reader.RefuseOthers();
  }

  const std::filesystem::path folder_;
  Findings& findings_;
  DeviceConfig config_;
};

}  // namespace

DeviceReading ReadDeviceText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<DeviceReading>(
      text, path,
      [&](const Table& root, Findings& findings) { return Reader(path, findings).Read(root); });
}

DeviceReading ReadDeviceFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadDeviceText);
}

}  // namespace musher::device
