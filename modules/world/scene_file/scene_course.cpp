#include "musher/modules/world/scene_file/scene_course.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/toml/names.hpp"
#include "musher/modules/world/scene/variation.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Listing;
using config_toml::Position;
using config_toml::Quote;
using config_toml::Row;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

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
  row::Sub("choices", {[&](TableReader& reader) {
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
           }})(root);
}

void Choices::ReadChosen(TableReader& root) {
  row::Sub("chosen", {[&](TableReader& reader) {
             for (const std::string_view key : KeysOf(*root.SubTable("chosen"))) {
               const std::string name(key);
               if (const auto value = reader.String(name))
                 Fix(name, value->text, value->at, "chosen." + name);
             }
           }})(root);
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
  row::Sub("follows", {[&](TableReader& follows) {
             for (const Choice& choice : choices_) {
               const Table* table = follows.SubTable(choice.name);
               if (table == nullptr) continue;
               TableReader reader(*table, follows.At(choice.name), "follows." + choice.name,
                                  findings_);
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
           }})(root);
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

namespace {

void ReadZone(TableReader& reader, Scene& scene) {
  Zone zone;
  keys::ReadSome(reader,
                 {row::Required("name", "the name of the zone", row::Text("name", zone.name)),
                  keys::Half("length_m", zone.half_m.x()), keys::Half("width_m", zone.half_m.y()),
                  keys::Center(zone.center_m), keys::Angle("yaw_deg", zone.yaw_rad),
                  row::Bool("lie", zone.lie)});
  scene.zones.push_back(std::move(zone));
}

// The zones in the order in which they are visited.
void ReadOrder(TableReader& reader, const Choices& choices, Findings& findings, Scene& scene) {
  std::vector<std::string_view> names;
  for (const Zone& zone : scene.zones) names.emplace_back(zone.name);
  const auto order = reader.Strings("order", {.may_be_empty = true, .may_repeat = true});
  for (const Word& word : order.value_or(std::vector<Word>())) {
    const Word zone = choices.Resolve(reader, "order", word);
    scene.referee.order.push_back(zone.text);
    if (zone.text == word.text && word.text.starts_with('$')) continue;  // reported
    if (std::find(names.begin(), names.end(), zone.text) != names.end()) continue;
    reader.Fault(zone.at, "order",
                 "unknown zone " + Quote(zone.text) +
                     (names.empty() ? "; the scene has no [[zone]]"
                                    : "; expected one of " + Listing(names) +
                                          findings.Guess(zone.text, names)));
  }
}

}  // namespace

void ReadReferee(TableReader& root, const Choices& choices, Findings& findings, Scene& scene) {
  keys::Each(root, "zone", findings, [&](TableReader& reader) { ReadZone(reader, scene); });
  RefereeSpec& referee = scene.referee;
  row::Sub(
      "referee",
      {keys::Length("stance_length_m", referee.stance_length_m),
       keys::Length("stance_width_m", referee.stance_width_m),
       keys::Length("foot_m", referee.foot_m), keys::Length("body_length_m", referee.body_length_m),
       keys::Length("body_width_m", referee.body_width_m),
       [&](TableReader& reader) { ReadOrder(reader, choices, findings, scene); }})(root);
}

Row VariationRow(Variation& by) {
  constexpr double kMostK = 4000;
  constexpr double kMostNoise = 32;
  return row::Sub(
      "vary",
      {row::Number("start_m", by.start_m, 0, 2), keys::Angle("start_deg", by.start_rad, 0, 180),
       keys::Angle("board_deg", by.board_rad, 0, 60),
       row::Number("brightness", by.brightness, 0, 0.9),
       row::Number("temperature_k", by.temperature_k, 0, kMostK),
       row::Number("slip", by.slip, 0, 0.5), row::Number("yaw_slip", by.yaw_slip, 0, 0.5),
       row::Number("odometry_scale", by.odometry_scale, 0, 0.5),
       keys::Angle("odometry_yaw_drift_deg_per_m", by.odometry_yaw_drift_rad_per_m, 0, 45),
       row::Number("camera_noise", by.camera_noise, 0, kMostNoise)});
}

}  // namespace musher::world
