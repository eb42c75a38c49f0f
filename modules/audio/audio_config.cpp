#include "musher/modules/audio/audio_config.hpp"

#include <filesystem>
#include <iterator>
#include <utility>
#include <variant>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::audio {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Quote;
using config_toml::Row;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::int64_t kLongestText = 10'000;
constexpr std::int64_t kSlowestVoice = 80;  // words a minute, of espeak-ng
constexpr std::int64_t kFastestVoice = 450;

// A non-empty string.
std::optional<std::string> Named(TableReader& reader, std::string_view key) {
  const auto word = reader.String(key);
  if (!word) return std::nullopt;
  if (!word->text.empty()) return word->text;
  reader.Fault(word->at, key, "expected a name, found nothing");
  return std::nullopt;
}

Row Name(std::string_view key, std::string& value) {
  return [=, &value](TableReader& reader) { value = Named(reader, key).value_or(value); };
}

Row NamedFile(std::string_view key, std::string& value, const std::filesystem::path& folder) {
  return [=, &value](TableReader& reader) {
    if (const auto name = Named(reader, key)) value = config_toml::Absolute(folder, *name);
  };
}

// What only some outputs use.
void CheckOutput(TableReader& root, const OutputConfig& output) {
  if (output.kind == OutputKind::kWav) {
    root.Require("folder", "the folder for the WAV files");
  } else if (root.Has("folder")) {
    root.Warn(root.At("folder"), "folder", "has no effect: only an output \"wav\" uses it");
  }
  const bool has_device = output.kind == OutputKind::kAlsa || output.kind == OutputKind::kAuto;
  if (!has_device && root.Has("device")) {
    root.Warn(root.At("device"), "device",
              R"(has no effect: only an output "auto" or "alsa" uses it)");
  }
}

void ReadTopic(TableReader& reader, const std::vector<CueTopic>& others, std::string& value) {
  const auto topic = reader.Topic("topic", "/show/play");
  if (!topic) return;
  value = topic->text;
  for (const CueTopic& other : others) {
    if (other.topic != topic->text) continue;
    reader.Fault(topic->at, "topic", Quote(topic->text) + " has its cues already");
  }
}

void ReadCueTopics(TableReader& root, const std::filesystem::path& folder, AudioConfig& config) {
  for (TableReader& reader : root.Subs("cues")) {
    CueTopic cue_topic;
    std::string file;
    ReadRows(reader,
             {row::Required(
                  "topic", "the topic that carries the names of cues",
                  [&](TableReader& cues) { ReadTopic(cues, config.cue_topics, cue_topic.topic); }),
              row::Bool("interrupts", cue_topic.interrupts),
              row::Required("file", "the file of the cues", NamedFile("file", file, folder))});
    config.cue_files.push_back(file);
    config.cue_topics.push_back(std::move(cue_topic));
  }
}

AudioConfig ReadAudio(const Table& table, const std::string& path, Findings& findings) {
  AudioConfig config;
  OutputConfig& output = config.output;
  VoiceConfig& voice = config.voice;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {row::Choice("output", output.kind,
                        {{"auto", OutputKind::kAuto},
                         {"alsa", OutputKind::kAlsa},
                         {"wav", OutputKind::kWav},
                         {"silent", OutputKind::kSilent}}),
            Name("device", output.device), NamedFile("folder", output.folder, folder),
            [&](TableReader& reader) { CheckOutput(reader, output); },
            row::Integer("volume", config.volume, 0, 100, "%"),
            row::Choice("language", config.language,
                        {{"en", Language::kEnglish}, {"zh", Language::kChinese}}),
            row::Integer("longest_text", config.longest_text, 1, kLongestText, "characters"),
            row::Required("phrases", "the file of the phrases",
                          row::File("phrases", config.phrases_file, folder)),
            [&](TableReader& reader) { ReadCueTopics(reader, folder, config); },
            row::Sub("voice", {row::Integer("words_per_minute", voice.words_per_minute,
                                            kSlowestVoice, kFastestVoice),
                               Name("english", voice.english), Name("chinese", voice.chinese)})});
  return config;
}

void Append(std::vector<Diagnostic>&& more, std::vector<Diagnostic>& diagnostics) {
  std::move(more.begin(), more.end(), std::back_inserter(diagnostics));
}

// Reads the files that the config names. Returns whether all are valid.
bool ReadFiles(AudioConfig& config, std::vector<Diagnostic>& diagnostics) {
  bool good = true;
  if (!config.phrases_file.empty()) {
    PhrasesReading reading = ReadPhrasesFile(config.phrases_file);
    Append(std::move(reading.diagnostics), diagnostics);
    good = reading.phrases.has_value();
    config.phrases = std::move(reading.phrases).value_or(Phrases());
  }
  for (std::size_t i = 0; i < config.cue_topics.size(); ++i) {
    if (config.cue_files[i].empty()) continue;  // which is reported already
    CuesReading reading = ReadCuesFile(config.cue_files[i]);
    Append(std::move(reading.diagnostics), diagnostics);
    good = good && reading.cues;
    config.cue_topics[i].cues = std::move(reading.cues).value_or(Cues());
  }
  return good;
}

}  // namespace

Parsed<AudioConfig> ReadAudioText(std::string_view text, const std::string& path) {
  Findings findings;
  std::optional<AudioConfig> config;
  const auto document = config_toml::ParseDocument(text);
  if (const auto* fault = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(fault->at, fault->message);
  } else {
    config = ReadAudio(std::get<Table>(document), path, findings);
  }
  bool good = config && !findings.HasErrors();
  Parsed<AudioConfig> reading{std::nullopt, std::move(findings).Take(path, text)};
  if (config) good = ReadFiles(*config, reading.diagnostics) && good;
  if (good) reading.config = std::move(config);
  return reading;
}

Parsed<AudioConfig> ReadAudioFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadAudioText);
}

}  // namespace musher::audio
