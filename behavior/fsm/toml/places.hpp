#pragma once
// Where the parts of a snapshot stand in its text, by the keys of SnapshotFault:
// "states.SHOW.time".

#include <map>
#include <string>

#include "musher/base/toml/table_reader.hpp"

namespace musher::fsm {

class Places {
 public:
  void Note(const std::string& key, config_toml::Position at) { places_[key] = at; }

  // The position of a key; of a missing part, the position of the table around it.
  config_toml::Position Where(std::string key) const {
    for (;;) {
      if (const auto found = places_.find(key); found != places_.end()) return found->second;
      const std::size_t dot = key.rfind('.');
      if (dot == std::string::npos) return {1, 1};
      key.resize(dot);
    }
  }

 private:
  std::map<std::string, config_toml::Position> places_;
};

}  // namespace musher::fsm
