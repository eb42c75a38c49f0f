#include <algorithm>
#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/messages/protocol/audio.hpp"
#include "musher/modules/audio/phrases.hpp"
#include "musher/modules/audio/spoken_toml.hpp"

namespace musher::audio {
namespace {

using config_toml::Findings;
using config_toml::Position;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Value;

constexpr std::int64_t kLargestId = 65'535;

class PhraseReader {
 public:
  PhraseReader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {}

  Phrases Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    for (const Value* value : root.Tables("phrase")) {
      TableReader reader(*value->As<Table>(), value->at, "phrase", findings_);
      ReadPhrase(reader);
      reader.RefuseOthers();
    }
    root.RefuseOthers();
    FindOverlaps();
    std::vector<Phrase> phrases;
    for (auto& [phrase, at] : found_) phrases.push_back(std::move(phrase));
    return Phrases(std::move(phrases));
  }

 private:
  void ReadPhrase(TableReader& reader) {
    Phrase phrase;
    reader.Require("id", "the phrase's number, 0 to 65535");
    const auto id = reader.Integer("id", 0, kLargestId);
    const auto last = reader.Integer("last_id", id.value_or(0), kLargestId);
    phrase.spoken = ReadSpoken(reader, folder_);
    for (const char* key : {"en", "zh"}) CheckMark(reader, key);
    if (!id) return;
    phrase.first = static_cast<std::uint16_t>(*id);
    phrase.last = static_cast<std::uint16_t>(last.value_or(*id));
    if (phrase.first <= msg::AudioPlay::kStop && msg::AudioPlay::kStop <= phrase.last) {
      reader.Fault(reader.At("id"), "id", "9999 stops what plays, it can be no phrase");
    }
    found_.emplace_back(std::move(phrase), reader.At("id"));
  }

  static void CheckMark(TableReader& reader, std::string_view key) {
    const Value* value = reader.Get(key);
    const auto* text = value == nullptr ? nullptr : value->As<std::string>();
    if (text == nullptr || text->find(kNumberMark) == std::string::npos) return;
    if (reader.Has("last_id")) return;
    reader.Fault(value->at, key, "{number} needs a last_id: it is the id minus the first one");
  }

  void FindOverlaps() {
    std::sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
      return std::pair(a.first.first, a.second) < std::pair(b.first.first, b.second);
    });
    const Found* widest = nullptr;  // so far
    for (const Found& found : found_) {
      if (widest != nullptr && found.first.first <= widest->first.last) {
        findings_.Error(found.second, "phrase.id: " + std::to_string(found.first.first) +
                                          " is a phrase already, at line " +
                                          std::to_string(widest->second.line));
      }
      if (widest == nullptr || found.first.last > widest->first.last) widest = &found;
    }
  }

  using Found = std::pair<Phrase, Position>;
  const std::filesystem::path folder_;
  Findings& findings_;
  std::vector<Found> found_;
};

}  // namespace

PhrasesReading ReadPhrasesText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<PhrasesReading>(text, path,
                                                   [&](const Table& root, Findings& findings) {
                                                     return PhraseReader(path, findings).Read(root);
                                                   });
}

PhrasesReading ReadPhrasesFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadPhrasesText);
}

}  // namespace musher::audio
