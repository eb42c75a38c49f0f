#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/audio/cues.hpp"
#include "musher/modules/audio/spoken_toml.hpp"

namespace musher::audio {
namespace {

using config_toml::Findings;
using config_toml::Position;
using config_toml::Quote;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Value;

Cues Read(const Table& table, const std::filesystem::path& folder, Findings& findings) {
  TableReader root(table, {1, 1}, "", findings);
  Cues cues;
  std::map<std::string, Position> places;
  for (const Value* value : root.Tables("cue")) {
    TableReader reader(*value->As<Table>(), value->at, "cue", findings);
    reader.Require("id", "the cue's name, as the topic carries it");
    Cue cue{ReadSpoken(reader, folder), reader.Bool("interrupts")};
    if (const auto id = reader.String("id")) {
      const auto [first, is_new] = places.emplace(id->text, id->at);
      if (id->text.empty()) reader.Fault(id->at, "id", "expected a name, found nothing");
      if (!is_new) {
        reader.Fault(
            id->at, "id",
            Quote(id->text) + " is a cue already, at line " + std::to_string(first->second.line));
      }
      cues.emplace(id->text, std::move(cue));
    }
    reader.RefuseOthers();
  }
  root.RefuseOthers();
  return cues;
}

}  // namespace

CuesReading ReadCuesText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<CuesReading>(
      text, path, [&](const Table& root, Findings& findings) {
        return Read(root, config_toml::FolderOf(path), findings);
      });
}

CuesReading ReadCuesFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadCuesText);
}

}  // namespace musher::audio
