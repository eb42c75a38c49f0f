#include "musher/modules/world/scene_file/scene_course.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/toml/names.hpp"
#include "musher/modules/world/scene/variation.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

using config_toml::Findings;
using config_toml::Listing;
using config_toml::Position;
using config_toml::Quote;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;
using keys::Set;

std::vector<std::string_view> KeysOf(const Table& table) {
  std::vector<std::string_view> keys;
  keys.reserve(table.size());
  for (const config_toml::Member& member : table) keys.emplace_back(member.key);
  return keys;
}

std::vector<std::string_view> Views(const std::vector<std::string>& words) {
  return {words.begin(), words.end()};
}

std::vector<std::string> Texts(const std::vector<Word>& words) {
  std::vector<std::string> texts;
  texts.reserve(words.size());
  for (const Word& word : words) texts.push_back(word.text);
  return texts;
}

}  // namespace

Choices::Choices(TableReader& root, std::uint64_t seed,
                 const std::map<std::string, std::string>& chosen, Findings& findings)
    : findings_(findings) {
  ReadChoices(root, seed);
  ReadChosen(root);
  for (const auto& [name, value] : chosen) Fix(name, value, {1, 1}, "--choose " + name);
  for (const Choice& choice : choices_) {
    values_[choice.name] = choice.values[choice.chosen];
    sampled_.push_back({choice.name, choice.values[choice.chosen]});
  }
  ReadFollows(root);
}

void Choices::ReadChoices(TableReader& root, std::uint64_t seed) {
  keys::Section(root, "choices", findings_, [&](TableReader& reader) {
    for (const std::string_view key : KeysOf(*root.SubTable("choices"))) {
      const std::string name(key);
      if (!config_toml::IsName(name)) {
        reader.Fault(reader.At(name), name,
                     "expected " + std::string(config_toml::kNameRule) + " as the name");
      }
      const auto values = reader.Strings(name);
      if (!values || values->empty()) continue;
      choices_.push_back({name, Texts(*values), SampleOf(seed, name) % values->size()});
    }
  });
}

void Choices::ReadChosen(TableReader& root) {
  keys::Section(root, "chosen", findings_, [&](TableReader& reader) {
    for (const std::string_view key : KeysOf(*root.SubTable("chosen"))) {
      const std::string name(key);
      if (const auto value = reader.String(name))
        Fix(name, value->text, value->at, "chosen." + name);
    }
  });
}

void Choices::Fix(const std::string& name, const std::string& value, Position at,
                  const std::string& what) {
  const auto found = std::find_if(choices_.begin(), choices_.end(),
                                  [&](const Choice& choice) { return choice.name == name; });
  if (found == choices_.end()) {
    std::vector<std::string_view> names;
    for (const Choice& choice : choices_) names.emplace_back(choice.name);
    if (names.empty()) return findings_.Error(at, what + ": the scene has no [choices]");
    return findings_.Error(at, what + ": unknown choice " + Quote(name) + "; expected one of " +
                                   Listing(names) + findings_.Guess(name, names));
  }
  const auto index = std::find(found->values.begin(), found->values.end(), value);
  if (index == found->values.end()) {
    const auto values = Views(found->values);
    return findings_.Error(at, what + ": expected one of " + Listing(values) + ", found " +
                                   Quote(value) + findings_.Guess(value, values));
  }
  found->chosen = static_cast<std::size_t>(index - found->values.begin());
}

void Choices::ReadFollows(TableReader& root) {
  keys::Section(root, "follows", findings_, [&](TableReader& follows) {
    for (const Choice& choice : choices_) {
      const Table* table = follows.SubTable(choice.name);
      if (table == nullptr) continue;
      TableReader reader(*table, follows.At(choice.name), "follows." + choice.name, findings_);
      for (const std::string_view key : KeysOf(*table)) {
        const auto values = reader.Strings(key, {.may_repeat = true});
        if (!values) continue;
        if (values->size() != choice.values.size()) {
          reader.Fault(reader.At(key), key,
                       "expected " + std::to_string(choice.values.size()) +
                           " values, one for each of choices." + choice.name);
          continue;
        }
        if (!values_.emplace(key, (*values)[choice.chosen].text).second) {
          reader.Fault(reader.At(key), key, "expected a name that is not used yet");
        }
      }
    }
  });
}

std::vector<std::string_view> Choices::Names() const {
  std::vector<std::string_view> names;
  for (const auto& [name, value] : values_) names.emplace_back(name);
  return names;
}

Word Choices::Resolve(TableReader& reader, std::string_view key, Word word) const {
  if (!word.text.starts_with('$') || !config_toml::IsName(word.text.substr(1))) return word;
  const std::string name = word.text.substr(1);
  if (const auto found = values_.find(name); found != values_.end()) {
    return {found->second, word.at};
  }
  const auto names = Names();
  reader.Fault(word.at, key,
               "unknown choice " + Quote(word.text) +
                   (names.empty() ? "; the scene has no [choices]"
                                  : "; expected $ and one of " + Listing(names) +
                                        findings_.Guess(name, names)));
  return word;
}

std::optional<Word> Choices::String(TableReader& reader, std::string_view key) const {
  auto word = reader.String(key);
  if (!word) return std::nullopt;
  return Resolve(reader, key, std::move(*word));
}

void ReadReferee(TableReader& root, const Choices& choices, Findings& findings, Scene& scene) {
  keys::Each(root, "zone", findings, [&](TableReader& reader) {
    reader.Require("name", "the name of the zone");
    for (const char* key : {"length_m", "width_m"}) reader.Require(key, "a length in metres");
    Zone zone;
    zone.name = keys::Name(reader);
    zone.center_m = keys::Center(reader);
    zone.half_m = {keys::Length(reader, "length_m").value_or(1) / 2,
                   keys::Length(reader, "width_m").value_or(1) / 2};
    Set(zone.yaw_rad, keys::Angle(reader, "yaw_deg"));
    Set(zone.lie, reader.Bool("lie"));
    scene.zones.push_back(std::move(zone));
  });
  keys::Section(root, "referee", findings, [&](TableReader& reader) {
    RefereeSpec& referee = scene.referee;
    for (const auto& [key, length] :
         {std::pair("stance_length_m", &referee.stance_length_m),
          std::pair("stance_width_m", &referee.stance_width_m),
          std::pair("foot_m", &referee.foot_m), std::pair("body_length_m", &referee.body_length_m),
          std::pair("body_width_m", &referee.body_width_m)}) {
      Set(*length, keys::Length(reader, key));
    }
    std::vector<std::string_view> names;
    for (const Zone& zone : scene.zones) names.emplace_back(zone.name);
    const auto order = reader.Strings("order", {.may_be_empty = true, .may_repeat = true});
    for (const Word& word : order.value_or(std::vector<Word>())) {
      const Word zone = choices.Resolve(reader, "order", word);
      referee.order.push_back(zone.text);
      if (zone.text == word.text && word.text.starts_with('$')) continue;  // reported
      if (std::find(names.begin(), names.end(), zone.text) != names.end()) continue;
      reader.Fault(zone.at, "order",
                   "unknown zone " + Quote(zone.text) +
                       (names.empty() ? "; the scene has no [[zone]]"
                                      : "; expected one of " + Listing(names) +
                                            findings.Guess(zone.text, names)));
    }
  });
}

Variation ReadVariation(TableReader& root, Findings& findings) {
  Variation by;
  keys::Section(root, "vary", findings, [&](TableReader& reader) {
    constexpr double kMostK = 4000;
    constexpr double kMostNoise = 32;
    Set(by.start_m, reader.Number("start_m", 0, 2));
    Set(by.start_rad, keys::Angle(reader, "start_deg", 0, 180));
    Set(by.board_rad, keys::Angle(reader, "board_deg", 0, 60));
    Set(by.brightness, reader.Number("brightness", 0, 0.9));
    Set(by.temperature_k, reader.Number("temperature_k", 0, kMostK));
    Set(by.slip, reader.Number("slip", 0, 0.5));
    Set(by.yaw_slip, reader.Number("yaw_slip", 0, 0.5));
    Set(by.odometry_scale, reader.Number("odometry_scale", 0, 0.5));
    Set(by.odometry_yaw_drift_rad_per_m,
        keys::Angle(reader, "odometry_yaw_drift_deg_per_m", 0, 45));
    Set(by.camera_noise, reader.Number("camera_noise", 0, kMostNoise));
  });
  return by;
}

}  // namespace musher::world
