#pragma once
// Reads what makes a scene a course: what the seed selects in a run, and what the referee watches.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/toml/rows.hpp"
#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

// The values of "$name" in a scene.
//
//   [choices]          one of these by the seed
//   [chosen]           which one, instead of the seed
//   [follows.NAME]     values that follow from the choice NAME, in the same sequence
class Choices {
 public:
  // Reports invalid tables. `chosen` replaces what [chosen] has. The findings outlive it.
  Choices(config_toml::TableReader& root, std::uint64_t seed,
          const std::map<std::string, std::string>& chosen, config_toml::Findings& findings);

  // The word, or the value of the choice of which it is the "$name"; an unknown name is reported.
  config_toml::Word Resolve(config_toml::TableReader& reader, std::string_view key,
                            config_toml::Word word) const;
  std::optional<config_toml::Word> String(config_toml::TableReader& reader,
                                          std::string_view key) const;

  // The choices of this run, without what follows from them.
  const std::vector<Sampled>& sampled() const { return sampled_; }

 private:
  struct Choice {
    std::string name;
    std::vector<std::string> values;
    std::size_t chosen = 0;
  };

  void ReadChoices(config_toml::TableReader& root, std::uint64_t seed);
  void ReadChosen(config_toml::TableReader& root);
  void ReadFollows(config_toml::TableReader& root);
  void Fix(const std::string& name, const std::string& value, config_toml::Position at,
           const std::string& what);
  std::vector<std::string_view> Names() const;

  config_toml::Findings& findings_;
  std::vector<Choice> choices_;
  std::map<std::string, std::string> values_;  // of this run, by name
  std::vector<Sampled> sampled_;
};

// [[zone]] and [referee].
void ReadReferee(config_toml::TableReader& root, const Choices& choices,
                 config_toml::Findings& findings, Scene& scene);

// [vary].
config_toml::Row VariationRow(Variation& by);

}  // namespace musher::world
