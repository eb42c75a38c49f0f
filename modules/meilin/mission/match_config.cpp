#include "musher/modules/meilin/mission/match_config.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "musher/base/joined.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/modules/meilin/plan/json_reader.hpp"

namespace musher::meilin {
namespace {

using Json = nlohmann::json;

constexpr std::array<std::string_view, 5> kPoseKeys = {"target_x", "target_y", "target_yaw",
                                                       "max_speed", "timeout_sec"};
constexpr std::array<std::string_view, 1> kLimitKeys = {"timeout_sec"};
constexpr std::array<std::string_view, 6> kFinishKeys = {
    "arm_command",          "timeout_sec",       "suspension_mode",
    "suspension_direction", "suspension_height", "suspension_timeout_sec"};

constexpr double kHighestWheelMm = 420;
constexpr double kFastest = 5;
constexpr double kFarthestInMatchM = 100;  // of a field of 10 m

struct Section {
  std::string_view area;
  std::string_view name;
  std::span<const std::string_view> keys;
};

const std::array<Section, 9>& Sections() {
  static const std::array<Section, 9> sections = {{{"prepare", "spear_prep", kPoseKeys},
                                                   {"prepare", "spear_grasp", kLimitKeys},
                                                   {"prepare", "align", kPoseKeys},
                                                   {"prepare", "dock", kLimitKeys},
                                                   {"final", "move2", kPoseKeys},
                                                   {"final", "final_move2", kPoseKeys},
                                                   {"final", "place_mid", kLimitKeys},
                                                   {"final", "place_high", kLimitKeys},
                                                   {"final", "finish", kFinishKeys}}};
  return sections;
}

class MatchReader {
 public:
  explicit MatchReader(const std::string& file) : file_(file) {}

  MatchReading Read(std::string_view text) {
    JsonFaults faults;
    const std::optional<Json> root = ParseJson(text, faults);
    for (const std::string& fault : faults.list()) Fault("", fault);
    if (root && IsObject(*root, "")) ReadRoot(*root);
    if (reading_.errors.empty()) reading_.config = std::move(config_);
    return std::move(reading_);
  }

 private:
  void ReadRoot(const Json& root) {
    RefuseOthers(root, "", std::array<std::string_view, 3>{"match_side", "prepare", "final"});
    if (const auto side = root.find("match_side"); side != root.end()) {
      const bool known = side->is_string() && (*side == "blue" || *side == "red");
      if (!known) Fault("match_side", "expected \"blue\" or \"red\", found " + side->dump());
      if (known) config_.side = SideOf(side->get<std::string>());
    }
    for (const std::string_view area : {std::string_view("prepare"), std::string_view("final")}) {
      const auto found = root.find(area);
      std::vector<std::string_view> names;
      for (const Section& section : Sections()) {
        if (section.area == area) names.push_back(section.name);
      }
      if (found == root.end()) {
        Fault(area, "missing; expected an object with " + Joined(names));
        continue;
      }
      if (!IsObject(*found, std::string(area))) continue;
      RefuseOthers(*found, std::string(area), names);
      for (const Section& section : Sections()) {
        if (section.area == area) ReadSection(*found, section);
      }
    }
  }

  void ReadSection(const Json& area, const Section& section) {
    const std::string path = fmt::format("{}.{}", section.area, section.name);
    const auto found = area.find(section.name);
    if (found == area.end()) {
      return Fault(path, "missing; expected an object with " + Joined(section.keys));
    }
    if (!IsObject(*found, path)) return;
    RefuseOthers(*found, path, section.keys);
    for (const std::string_view key : section.keys) {
      const std::string key_path = fmt::format("{}.{}", path, key);
      const auto value = found->find(key);
      if (value == found->end()) {
        Fault(key_path, "missing; expected a number");
      } else if (!value->is_number() || !std::isfinite(value->get<double>())) {
        Fault(key_path, "expected a number, found " + value->dump());
      } else if (const std::string why = WrongValue(key, value->get<double>()); !why.empty()) {
        Fault(key_path, why + ", found " + value->dump());
      } else {
        config_.entries.emplace_back(fmt::format("{}_{}_{}", section.area, section.name, key),
                                     value->get<double>());
      }
    }
  }

  static std::string WrongValue(std::string_view key, double value) {
    const bool whole = std::trunc(value) == value;
    if (key.ends_with("timeout_sec") && (value <= 0 || value > 3600)) {
      return "expected a limit of more than 0 and up to 3600 s";
    }
    if (key == "arm_command" && (!whole || value < 0 || value > 6)) return "expected 0 to 6";
    if ((key == "suspension_mode" || key == "suspension_direction") &&
        (!whole || value < 0 || value > 3)) {
      return "expected 0 to 3";
    }
    if (key == "suspension_height" && (value < 0 || value > kHighestWheelMm)) {
      return "expected 0 to 420 mm, the reach of a wheel";
    }
    if (key == "max_speed" && (value <= 0 || value > kFastest)) {
      return "expected more than 0 and up to 5 m/s";
    }
    if ((key == "target_x" || key == "target_y") && std::abs(value) > kFarthestInMatchM) {
      return "expected -100 to 100 m";
    }
    if (key == "target_yaw" && std::abs(value) > 2 * kPi) return "expected -2 pi to 2 pi rad";
    return "";
  }

  bool IsObject(const Json& value, const std::string& path) {
    if (value.is_object()) return true;
    Fault(path, "expected an object, found " + value.dump().substr(0, 40));
    return false;
  }

  template <class Keys>
  void RefuseOthers(const Json& object, const std::string& path, const Keys& known) {
    const std::vector<std::string> words(known.begin(), known.end());
    for (const auto& item : object.items()) {
      if (std::ranges::find(words, item.key()) != words.end()) continue;
      Fault(path.empty() ? item.key() : path + "." + item.key(),
            "unknown key" + DidYouMean(item.key(), words));
    }
  }

  void Fault(std::string_view path, const std::string& what) {
    reading_.errors.push_back(file_ + ": " + std::string(path) + (path.empty() ? "" : ": ") + what);
  }

  const std::string file_;
  MatchConfig config_;
  MatchReading reading_;
};

}  // namespace

MatchReading ReadMatchText(std::string_view text, const std::string& file) {
  return MatchReader(file).Read(text);
}

MatchReading ReadMatchFile(const std::string& path) {
  Result<std::string> text = config_toml::ReadModuleText(path);
  if (!text) return {std::nullopt, {path + ": " + text.error().message}};
  return ReadMatchText(text.value(), path);
}

}  // namespace musher::meilin
