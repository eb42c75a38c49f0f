#include "musher/modules/vp_engine/vp_config.hpp"

#include <filesystem>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::vp_engine {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Row;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

// A folder, which is relative to that of the config.
Row Folder(std::string_view key, std::string& value, std::filesystem::path folder) {
  return [=, &value, folder = std::move(folder)](TableReader& reader) {
    const std::optional<Word> path = reader.String(key);
    if (!path) return;
    if (path->text.empty()) {
      return reader.Fault(path->at, key, "expected a folder, found an empty text");
    }
    value = config_toml::Absolute(folder, path->text);
  };
}

Row Service(std::string_view key, std::string& service) {
  return row::Topic(key, service, "led_execute", {.of = "a service"});
}

VpConfig Read(const Table& table, const std::string& path, Findings& findings) {
  VpConfig config;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  config.folder = config_toml::DefaultStateDir("programs", "");
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {Folder("folder", config.folder, folder), Folder("examples", config.examples, folder),
            row::Number("rate_hz", config.rate_hz, 1, 1000),
            row::Integer("groot2_port", config.groot2_port, 0, 65'534),
            row::Text("groot2_address", config.groot2_address),
            row::Bool("groot2_hooks", config.groot2_hooks), row::Text("record", config.record),
            row::Integer("record_mib", config.record_mib, 1, 256),
            row::Sub("services",
                     {Service("speech", config.speech), row::Time("speech_ms", config.speech_time),
                      Service("motion", config.motion), row::Time("motion_ms", config.motion_time),
                      Service("light", config.light), row::Time("light_ms", config.light_time)})});
  return config;
}

}  // namespace

Parsed<VpConfig> ReadVpText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<VpConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings); });
}

Parsed<VpConfig> ReadVpFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadVpText);
}

}  // namespace musher::vp_engine
