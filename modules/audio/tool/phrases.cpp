// musher-audio phrases: lists the phrases and their numbers.

#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "musher/base/program_path.hpp"
#include "musher/modules/audio/phrases.hpp"
#include "musher/modules/audio/tool/commands.hpp"

namespace musher::audio::tool {
namespace {

namespace fs = std::filesystem;

// Next to an installed program, or in the tree that it was built in.
std::string PhrasesFile() {
  const fs::path bin = OwnProgram().parent_path();
  const fs::path installed = bin / "../share/musher/config/audio/phrases.toml";
  std::error_code error;
  if (fs::exists(installed, error)) return installed.lexically_normal();
  return (bin / "../../../config/audio/phrases.toml").lexically_normal();
}

std::string TextOf(const Phrase& phrase, Language language) {
  const auto text = phrase.spoken.texts.find(language);
  return text == phrase.spoken.texts.end() ? "" : text->second;
}

void PrintJson(const Phrases& phrases) {
  nlohmann::json list = nlohmann::json::array();
  for (const Phrase& phrase : phrases.all()) {
    nlohmann::json row = {{"id", phrase.first}, {"last_id", phrase.last}};
    for (const auto& [language, text] : phrase.spoken.texts) {
      row[language == Language::kChinese ? "zh" : "en"] = text;
    }
    if (!phrase.spoken.recording.empty()) row["recording"] = phrase.spoken.recording;
    list.push_back(std::move(row));
  }
  std::cout << list.dump(2) << std::endl;
}

void PrintText(const Phrases& phrases) {
  constexpr std::size_t kIdWidth = 13;
  for (const Phrase& phrase : phrases.all()) {
    std::string id = std::to_string(phrase.first);
    if (phrase.last != phrase.first) id += " to " + std::to_string(phrase.last);
    std::cout << std::string(id.size() < kIdWidth ? kIdWidth - id.size() : 0, ' ') << id;
    for (const std::string& part : {TextOf(phrase, Language::kEnglish),
                                    TextOf(phrase, Language::kChinese), phrase.spoken.recording}) {
      if (!part.empty()) std::cout << "  " << part;
    }
    std::cout << "\n";
  }
  std::cout << std::flush;
}

}  // namespace

ExitCode Run(const GlobalOptions& global, const PhrasesOptions&) {
  const PhrasesReading reading =
      ReadPhrasesFile(global.phrases.empty() ? PhrasesFile() : global.phrases);
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    std::cerr << FormatDiagnostic(diagnostic) << std::endl;
  }
  if (!reading.phrases) return ExitCode::kUsage;
  if (global.json) {
    PrintJson(*reading.phrases);
  } else {
    PrintText(*reading.phrases);
  }
  return ExitCode::kDone;
}

}  // namespace musher::audio::tool
