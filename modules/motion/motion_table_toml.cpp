#include <algorithm>
#include <map>
#include <string>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/motion/motion_table.hpp"

namespace musher::motion {
namespace {

using config_toml::Array;
using config_toml::Findings;
using config_toml::Member;
using config_toml::Position;
using config_toml::Quote;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Value;

constexpr std::int64_t kHighestId = 99'999;
constexpr std::int64_t kHighestMode = 127;  // int8 on the board's wire
constexpr std::int64_t kLongestMs = 600'000;
constexpr double kHighestSpeed = 10.0;

// The motions that the manager itself commands.
constexpr std::array kNeeded = {kEmergencyStop, kGetDown,   kPassiveGetDown,
                                kRecoveryStand, kWalkStand, kGroundStand};

class Reader {
 public:
  explicit Reader(Findings& findings) : findings_(findings) {}

  MotionTable Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    if (const Table* groups = root.SubTable("group")) {
      for (const Member& member : *groups) ReadGroup(member);
    }
    root.Require("motion", "an array with a table for each motion");
    for (const Value* row : root.Tables("motion")) ReadMotion(*row);
    if (root.Has("motion")) {
      for (const std::int32_t id : kNeeded) {
        if (places_.count(id) == 0) {
          root.Fault(root.At("motion"), "motion",
                     "there is no motion " + std::to_string(id) +
                         ", which the motion manager itself commands");
        }
      }
    }
    root.RefuseOthers();
    return MotionTable(std::move(motions_));
  }

 private:
  using Modes = std::vector<std::int8_t>;

  void ReadGroup(const Member& member) {
    if (const auto modes = ReadModes(member.value, "group." + member.key)) {
      groups_.emplace(member.key, *modes);
    }
  }

  std::optional<Modes> ReadModes(const Value& value, const std::string& path) {
    const auto* array = value.As<Array>();
    if (array == nullptr || array->empty()) {
      findings_.Error(value.at, path + ": expected an array of modes, found " +
                                    (array == nullptr ? std::string(TypeName(value))
                                                      : std::string("an empty one")));
      return std::nullopt;
    }
    Modes modes;
    for (const Value& item : *array) {
      const auto* mode = item.As<std::int64_t>();
      if (mode == nullptr || *mode < 0 || *mode > kHighestMode) {
        findings_.Error(
            item.at, path + ": expected a mode from 0 to 127, found " +
                         (mode == nullptr ? std::string(TypeName(item)) : std::to_string(*mode)));
      } else {
        modes.push_back(static_cast<std::int8_t>(*mode));
      }
    }
    return modes;
  }

  void ReadMotion(const Value& value) {
    TableReader row(*value.As<Table>(), value.at, "motion", findings_);
    for (const auto* key : {"id", "name", "mode", "gait", "min_exec_time_ms", "next"}) {
      row.Require(key, "a value");
    }
    Motion motion;
    const auto id = row.Integer("id", 0, kHighestId);
    motion.id = static_cast<std::int32_t>(id.value_or(0));
    if (const auto name = row.String("name")) motion.name = name->text;
    const auto mode = row.Integer("mode", 0, kHighestMode);
    const auto gait = row.Integer("gait", 0, kHighestMode);
    motion.mode = static_cast<std::int8_t>(mode.value_or(0));
    motion.gait = static_cast<std::int8_t>(gait.value_or(0));
    motion.min_exec_time_ms = row.Integer("min_exec_time_ms", -1, kLongestMs, "ms").value_or(0);
    motion.next = ReadNext(row);
    motion.capability = ReadCapability(row, "capability");
    motion.servo = ReadCapability(row, "servo");
    motion.limit = ReadLimit(row);
    if (id && motion.id != kEmergencyStop && !row.Has("capability")) {
      row.Fault(row.at(), "capability", "is missing; only emergency stop is never refused");
    }
    row.RefuseOthers();
    if (id) Claim(places_, motion.id, row.At("id"), "id " + std::to_string(*id));
    if (mode && gait) {
      Claim(names_, std::pair(motion.mode, motion.gait), row.At("mode"),
            "mode " + std::to_string(*mode) + " with gait " + std::to_string(*gait));
    }
    motions_.push_back(std::move(motion));
  }

  Modes ReadNext(TableReader& row) {
    const Value* next = row.Get("next");
    if (next == nullptr) return {};
    const auto* name = next->As<std::string>();
    if (name == nullptr) return ReadModes(*next, "motion.next").value_or(Modes{});
    const auto group = groups_.find(*name);
    if (group != groups_.end()) return group->second;
    std::vector<std::string_view> known;
    for (const auto& [key, modes] : groups_) known.push_back(key);
    row.Fault(next->at, "next",
              "there is no group " + Quote(*name) + findings_.Guess(*name, known));
    return {};
  }

  std::string ReadCapability(TableReader& row, std::string_view key) {
    const auto word = row.String(key);
    if (!word) return "";
    if (!config_toml::IsName(word->text)) {
      row.Fault(word->at, key, "expected " + std::string(config_toml::kNameRule));
    }
    return word->text;
  }

  std::optional<SpeedLimit> ReadLimit(TableReader& row) {
    const Table* table = row.SubTable("limit");
    if (table == nullptr) return std::nullopt;
    TableReader reader(*table, row.At("limit"), "motion.limit", findings_);
    SpeedLimit limit{};
    std::size_t axis = 0;
    for (const auto* key : {"vx", "vy", "yaw"}) {
      reader.Require(key, "a speed");
      limit[axis++] = static_cast<float>(reader.Number(key, 0, kHighestSpeed).value_or(0));
    }
    reader.RefuseOthers();
    return limit;
  }

  // Reports the second of two entries with the same key.
  template <class Key>
  void Claim(std::map<Key, Position>& places, Key key, Position at, const std::string& what) {
    const auto [place, first] = places.emplace(key, at);
    if (first) return;
    findings_.Error(at, "motion: " + what + " is already defined in line " +
                            std::to_string(place->second.line) + " already");
  }

  Findings& findings_;
  std::map<std::string, Modes> groups_;
  std::map<std::int32_t, Position> places_;
  std::map<std::pair<std::int8_t, std::int8_t>, Position> names_;
  std::vector<Motion> motions_;
};

}  // namespace

TableReading ReadTableText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<TableReading>(
      text, path,
      [](const Table& root, Findings& findings) { return Reader(findings).Read(root); });
}

TableReading ReadTableFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadTableText);
}

}  // namespace musher::motion
