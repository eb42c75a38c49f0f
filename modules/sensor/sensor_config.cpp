#include "musher/modules/sensor/sensor_config.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::sensor {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr double kLeastHz = 0.01;
constexpr double kMostHz = 1000;

// What the module publishes: a subscription to it would be a loop.
const std::set<std::string, std::less<>> kOwnTopics = {
    "scan", "ultrasonic_payload", "head_tof_payload", "rear_tof_payload", "gps_payload"};

class Reader {
 public:
  explicit Reader(Findings& findings) : findings_(findings) {}

  ManagerConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    Rows rows = {
        row::Time("self_check_ms", config_.self_check_time),
        row::Time("start_ms", config_.start_time),
        row::Time("stamp_tolerance_ms", config_.stamp_tolerance, 0),
        [this](TableReader& reader) {
          config_.ros_distro =
              reader.Choice<RosDistro>("ros_distro", {{"galactic", RosDistro::kGalactic},
                                                      {"humble", RosDistro::kHumble},
                                                      {"iron", RosDistro::kIron},
                                                      {"jazzy", RosDistro::kJazzy},
                                                      {"kilted", RosDistro::kKilted}});
        },
        [this](TableReader& reader) { config_.skip = Kinds(reader, "skip"); },
        [this](TableReader& reader) { config_.critical = Kinds(reader, "critical"); },
    };
    for (const SensorKind kind : kSensorKinds) {
      rows.push_back(row::Sub(NameOf(kind),
                              {[this, kind](TableReader& reader) { ReadSensor(reader, kind); }}));
    }
    ReadRows(root, rows);
    return std::move(config_);
  }

 private:
  std::vector<SensorKind> Kinds(TableReader& root, std::string_view key) {
    const auto words = root.Strings(key, {.may_be_empty = true});
    std::vector<SensorKind> kinds;
    if (!words) return kinds;
    std::vector<std::string_view> known(kSensorKinds.size());
    std::transform(kSensorKinds.begin(), kSensorKinds.end(), known.begin(), NameOf);
    for (const Word& word : *words) {
      const std::optional<SensorKind> kind = KindOfName(word.text);
      if (!kind) {
        root.Fault(word.at, key,
                   "expected one of " + config_toml::Listing(known) + ", found " +
                       config_toml::Quote(word.text) + findings_.Guess(word.text, known));
        continue;
      }
      const auto& skip = config_.skip;
      if (key == "critical" && std::find(skip.begin(), skip.end(), *kind) != skip.end()) {
        root.Fault(word.at, key, "a sensor that is skipped cannot be critical");
      }
      kinds.push_back(*kind);
    }
    return kinds;
  }

  void ReadSensor(TableReader& reader, SensorKind kind) {
    SensorConfig& sensor = config_.Of(kind);
    if (kind == SensorKind::kTof) {
      for (const std::string_view key : kTofKeys) sensor.sources.push_back(Source(reader, key));
    } else {
      sensor.sources.push_back(Source(reader, "source"));
    }
    if (const auto rate = reader.Number("rate_hz", kLeastHz, kMostHz)) {
      sensor.period = FromSeconds(1 / *rate);
    }
    sensor.silence = reader.Time("silence_ms").value_or(sensor.silence);
    if (kind == SensorKind::kGps && reader.Has("satellites")) {
      sensor.satellites = Source(reader, "satellites");
    }
  }

  std::string Source(TableReader& reader, std::string_view key) {
    if (key != "satellites") {
      reader.Require(key, "the topic of its readings, as in \"world/scan\"");
    }
    const auto topic = reader.Topic(key, "world/scan", {.relative = true});
    if (!topic) return "";
    if (kOwnTopics.contains(topic->text)) {
      reader.Fault(topic->at, key, "this is a topic that the module publishes itself");
    } else if (!used_.insert(topic->text).second) {
      reader.Fault(topic->at, key, "another sensor has this topic already");
    }
    return topic->text;
  }

  Findings& findings_;
  ManagerConfig config_;
  std::set<std::string> used_;
};

}  // namespace

Parsed<ManagerConfig> ReadManagerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<ManagerConfig>>(
      text, path,
      [](const Table& root, Findings& findings) { return Reader(findings).Read(root); });
}

Parsed<ManagerConfig> ReadManagerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadManagerText);
}

}  // namespace musher::sensor
