#include "musher/modules/audio/spoken_toml.hpp"

#include "musher/base/toml/names.hpp"
#include "musher/modules/audio/sound_file.hpp"

namespace musher::audio {
namespace {

using config_toml::TableReader;

void ReadText(TableReader& reader, std::string_view key, Language language, Spoken& spoken) {
  const auto text = reader.String(key);
  if (!text) return;
  if (!HasSomethingToSay(text->text)) {
    return reader.Fault(text->at, key, "expected a text, found nothing to say");
  }
  spoken.texts[language] = text->text;
}

}  // namespace

Spoken ReadSpoken(TableReader& reader, const std::filesystem::path& folder) {
  Spoken spoken;
  ReadText(reader, "en", Language::kEnglish, spoken);
  ReadText(reader, "zh", Language::kChinese, spoken);
  if (const auto recording = reader.String("recording")) {
    spoken.recording = config_toml::Absolute(folder, recording->text);
    if (const Result<> good = CheckSound(spoken.recording); !good) {
      reader.Fault(recording->at, "recording", good.error().message);
    }
  } else if (!reader.Has("en") && !reader.Has("zh") && !reader.Has("recording")) {
    reader.Fault(reader.at(), "id", "expected a text (en, zh) or a recording with it");
  }
  return spoken;
}

}  // namespace musher::audio
