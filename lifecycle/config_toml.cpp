#include "musher/lifecycle/config_toml.hpp"

#include <cstdint>
#include <cstdio>
#include <utility>
#include <variant>

#include "musher/lifecycle/checksum.hpp"
#include "musher/lifecycle/suggest.hpp"
#include "musher/lifecycle/toml/document.hpp"
#include "musher/lifecycle/toml/draft.hpp"
#include "musher/lifecycle/toml/file.hpp"
#include "musher/lifecycle/toml/findings.hpp"
#include "musher/lifecycle/toml/names.hpp"
#include "musher/lifecycle/toml/table_reader.hpp"

namespace musher {
namespace {

using config_toml::Draft;
using config_toml::Member;
using config_toml::Quote;
using config_toml::SyntaxFault;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::size_t kLargestFile = 8U << 20;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

ConfigReading Refuse(const std::string& path, const std::string& message) {
  return {std::nullopt, {{path, 0, 0, Severity::kError, message}}};
}

ConfigReading RefuseSize(const std::string& path) {
  return Refuse(path, "the file is too large: expected a state config of at most 8 MiB");
}

// What the file has in place of a [controller] table.
SyntaxFault NotAStateConfig(const Table& root) {
  const std::string message = "not a state config: expected a [controller] table, found ";
  if (root.empty()) return {{}, message + "an empty file"};
  const Member* shown = nullptr;
  for (const Member& member : root) {
    const bool is_slip = !Nearest(member.key, std::vector<std::string_view>{"controller"}).empty();
    const bool is_table = member.value.As<Table>() != nullptr;
    if (is_slip && is_table) {
      return {member.at, message + "[" + member.key + "]; did you mean \"controller\"?"};
    }
    if (is_table && shown == nullptr) shown = &member;
  }
  if (shown != nullptr) return {shown->at, message + "[" + shown->key + "]"};
  return {root.front().at, message + "the key " + Quote(root.front().key)};
}

void ReadSections(const Table& table, Draft& draft) {
  TableReader root(table, {1, 1}, "", draft.findings);
  for (const auto* key : {"controller", "actuator", "state", "transition", "transport", "security",
                          "policy", "capability"}) {
    root.Get(key);
  }
  root.RefuseOthers();
  ReadOwnStates(root, draft);
  ReadController(root, draft);
  ReadTransitions(root, draft);
  ReadTransport(root, draft);
  ReadSecurity(root, draft);
  ReadPolicy(root, draft);
  ReadActuators(root, draft);
  ReadCapabilities(root, draft);
}

}  // namespace

std::string ConfigHash(std::string_view text) {
  char hex[17];
  std::snprintf(hex, sizeof hex, "%016llx", static_cast<unsigned long long>(Fnv1a(text)));
  return hex;
}

ConfigReading ReadConfigText(std::string_view text, const std::string& path) {
  if (text.size() > kLargestFile) return RefuseSize(path);
  Draft draft;
  draft.config.file = path;
  draft.config.hash = ConfigHash(text);
  draft.folder = config_toml::FolderOf(path);
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());

  const auto document = config_toml::ParseDocument(text);
  const auto* table = std::get_if<Table>(&document);
  if (table == nullptr) {
    const auto& fault = std::get<SyntaxFault>(document);
    draft.findings.Error(fault.at, fault.message);
  } else if (config_toml::Find(*table, "controller") == nullptr) {
    const SyntaxFault fault = NotAStateConfig(*table);
    draft.findings.Error(fault.at, fault.message);
  } else {
    ReadSections(*table, draft);
  }
  ConfigReading reading;
  if (!draft.findings.HasErrors()) reading.config = std::move(draft.config);
  reading.diagnostics = std::move(draft.findings).Take(path, text);
  return reading;
}

ConfigReading ReadConfigFile(const std::string& path) {
  const Result<std::string> text = config_toml::ReadTextFile(path, kLargestFile);
  return text ? ReadConfigText(text.value(), path) : Refuse(path, text.error().message);
}

}  // namespace musher
