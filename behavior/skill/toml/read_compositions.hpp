#pragma once
// Reads the compositions of a config: tables [skill.NAME] with one of the keys in_order, parallel
// and first_to_finish. They may run each other, in any order of the file; a cycle is refused.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "musher/base/toml/table_reader.hpp"
#include "musher/behavior/skill/registry.hpp"

namespace musher::skill {

class Run;

class CompositionReader {
 public:
  // `findings` must outlive the reader.
  CompositionReader(const Registry& registry, config_toml::Findings& findings);

  // A table [skill.NAME] of the file, which must outlive the reader. Ignored, unless it has one of
  // the keys.
  void Note(const config_toml::Member& member);
  bool Has(const std::string& name) const { return drafts_.contains(name); }
  // Names of all skills: the registered ones and the compositions.
  std::vector<std::string> Names() const;
  // With the compositions that have been read.
  const Registry& known() const { return known_; }

  // Reads all of them; each comes after those that it runs. `read_rest` reads the other keys of
  // one.
  using ReadRest = std::function<void(config_toml::TableReader&, const Run&)>;
  std::vector<Config::Composition> Read(const ReadRest& read_rest);

 private:
  struct Draft {
    const config_toml::Member* member = nullptr;
    bool clashes = false;  // with a registered skill
    bool begun = false;
    bool ended = false;
    std::size_t skills = 0;  // with those inside; 0: it has errors
  };

  std::size_t ReadOne(const std::string& name);
  std::size_t ReadParts(config_toml::TableReader& table, const std::string& key,
                        std::vector<Part>& parts);
  std::size_t ReadPart(const config_toml::Value& value, const std::string& path,
                       std::vector<Part>& parts);
  std::size_t SizeOf(const config_toml::Word& skill, const std::string& path);

  Registry known_;
  config_toml::Findings& findings_;
  std::map<std::string, Draft> drafts_;
  std::vector<std::string> order_;    // of the file
  std::vector<std::string> reading_;  // each is a part of the one before
  std::vector<Config::Composition> read_;
  ReadRest read_rest_;
};

}  // namespace musher::skill
