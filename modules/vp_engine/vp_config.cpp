#include "musher/modules/vp_engine/vp_config.hpp"

#include <filesystem>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::vp_engine {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

std::string PathOf(TableReader& root, std::string_view key, const std::filesystem::path& folder,
                   const std::string& otherwise) {
  const std::optional<Word> path = root.String(key);
  if (!path) return otherwise;
  if (path->text.empty()) {
    root.Fault(path->at, key, "expected a folder, found an empty text");
    return otherwise;
  }
  return config_toml::Absolute(folder, path->text);
}

void ReadCall(TableReader& calls, std::string_view name, std::string& service, Duration& time) {
  if (const std::optional<Word> word = calls.String(name)) {
    service = word->text;
    if (!config_toml::IsTopic(service)) {
      calls.Fault(
          word->at, name,
          "expected a service as in \"led_execute\", found " + config_toml::Quote(word->text));
    }
  }
  time = calls.Time(std::string(name) + "_ms").value_or(time);
}

VpConfig Read(const Table& table, const std::string& path, Findings& findings) {
  VpConfig config;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  TableReader root(table, {1, 1}, "", findings);
  config.folder = PathOf(root, "folder", folder, config_toml::DefaultStateDir("programs", ""));
  config.examples = PathOf(root, "examples", folder, "");
  config.rate_hz = root.Number("rate_hz", 1, 1000).value_or(config.rate_hz);
  config.groot2_port = static_cast<int>(root.Integer("groot2_port", 0, 65'534).value_or(0));
  if (const auto address = root.String("groot2_address")) config.groot2_address = address->text;
  config.groot2_hooks = root.Bool("groot2_hooks").value_or(false);
  if (const auto record = root.String("record")) config.record = record->text;
  config.record_mib = static_cast<std::size_t>(root.Integer("record_mib", 1, 256).value_or(16));
  if (const Table* calls = root.SubTable("services")) {
    TableReader reader(*calls, root.At("services"), "services", findings);
    ReadCall(reader, "speech", config.speech, config.speech_time);
    ReadCall(reader, "motion", config.motion, config.motion_time);
    ReadCall(reader, "light", config.light, config.light_time);
    reader.RefuseOthers();
  }
  root.RefuseOthers();
  return config;
}

}  // namespace

VpReading ReadVpText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<VpReading>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings); });
}

VpReading ReadVpFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadVpText);
}

}  // namespace musher::vp_engine
