#include "musher/modules/audio/audio_config.hpp"

#include <filesystem>
#include <iterator>
#include <utility>
#include <variant>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::audio {
namespace {

using config_toml::Findings;
using config_toml::Quote;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::int64_t kLongestText = 10'000;
constexpr std::int64_t kSlowestVoice = 80;  // words a minute, of espeak-ng
constexpr std::int64_t kFastestVoice = 450;

class Reader {
 public:
  Reader(const std::string& path, Findings& findings)
      : folder_(config_toml::FolderOf(path)), findings_(findings) {}

  AudioConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    ReadOutput(root);
    if (const auto volume = root.Integer("volume", 0, 100, "%")) {
      config_.volume = static_cast<int>(*volume);
    }
    const auto language =
        root.Choice<Language>("language", {{"en", Language::kEnglish}, {"zh", Language::kChinese}});
    config_.language = language.value_or(config_.language);
    if (const auto longest = root.Integer("longest_text", 1, kLongestText, "characters")) {
      config_.longest_text = static_cast<std::size_t>(*longest);
    }
    root.Require("phrases", "the file of the phrases");
    if (const auto phrases = root.String("phrases")) {
      config_.phrases_file = config_toml::Absolute(folder_, phrases->text);
    }
    for (const config_toml::Value* value : root.Tables("cues")) {
      TableReader reader(*value->As<Table>(), value->at, "cues", findings_);
      ReadCueTopic(reader);
      reader.RefuseOthers();
    }
    if (const Table* voice = root.SubTable("voice")) {
      TableReader reader(*voice, root.At("voice"), "voice", findings_);
      ReadVoice(reader);
      reader.RefuseOthers();
    }
    root.RefuseOthers();
    return std::move(config_);
  }

 private:
  void ReadOutput(TableReader& root) {
    OutputConfig& output = config_.output;
    const auto kind = root.Choice<OutputKind>("output", {{"auto", OutputKind::kAuto},
                                                         {"alsa", OutputKind::kAlsa},
                                                         {"wav", OutputKind::kWav},
                                                         {"silent", OutputKind::kSilent}});
    output.kind = kind.value_or(output.kind);
    output.device = Named(root, "device").value_or(output.device);
    if (const auto folder = Named(root, "folder")) {
      output.folder = config_toml::Absolute(folder_, *folder);
    }
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

  void ReadCueTopic(TableReader& reader) {
    CueTopic cue_topic;
    reader.Require("topic", "the topic that carries the names of cues");
    if (const auto topic = reader.String("topic")) {
      cue_topic.topic = topic->text;
      CheckTopic(reader, *topic);
    }
    cue_topic.interrupts = reader.Bool("interrupts").value_or(cue_topic.interrupts);
    reader.Require("file", "the file of the cues");
    const auto file = Named(reader, "file");
    config_.cue_files.push_back(file ? config_toml::Absolute(folder_, *file) : "");
    config_.cue_topics.push_back(std::move(cue_topic));
  }

  void CheckTopic(TableReader& reader, const config_toml::Word& topic) const {
    if (!config_toml::IsTopic(topic.text)) {
      reader.Fault(topic.at, "topic",
                   "expected a topic, as in \"/show/play\", found " + Quote(topic.text));
    }
    for (const CueTopic& other : config_.cue_topics) {
      if (other.topic != topic.text) continue;
      reader.Fault(topic.at, "topic", Quote(topic.text) + " has its cues already");
    }
  }

  void ReadVoice(TableReader& reader) {
    VoiceConfig& voice = config_.voice;
    if (const auto speed = reader.Integer("words_per_minute", kSlowestVoice, kFastestVoice)) {
      voice.words_per_minute = static_cast<int>(*speed);
    }
    voice.english = Named(reader, "english").value_or(voice.english);
    voice.chinese = Named(reader, "chinese").value_or(voice.chinese);
  }

  // A non-empty string.
  static std::optional<std::string> Named(TableReader& reader, std::string_view key) {
    const auto word = reader.String(key);
    if (!word) return std::nullopt;
    if (!word->text.empty()) return word->text;
    reader.Fault(word->at, key, "expected a name, found nothing");
    return std::nullopt;
  }

  const std::filesystem::path folder_;
  Findings& findings_;
  AudioConfig config_;
};

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

AudioReading ReadAudioText(std::string_view text, const std::string& path) {
  Findings findings;
  std::optional<AudioConfig> config;
  const auto document = config_toml::ParseDocument(text);
  if (const auto* fault = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(fault->at, fault->message);
  } else {
    config = Reader(path, findings).Read(std::get<Table>(document));
  }
  bool good = config && !findings.HasErrors();
  AudioReading reading{std::nullopt, std::move(findings).Take(path, text)};
  if (config) good = ReadFiles(*config, reading.diagnostics) && good;
  if (good) reading.config = std::move(config);
  return reading;
}

AudioReading ReadAudioFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadAudioText);
}

}  // namespace musher::audio
