#include "musher/lifecycle/config/config_toml.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <variant>

#include "musher/base/checksum.hpp"
#include "musher/base/suggest.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"

namespace musher {
namespace {

using config_toml::Array;
using config_toml::Draft;
using config_toml::Member;
using config_toml::Quote;
using config_toml::SyntaxFault;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Value;

constexpr std::size_t kLargestFile = 8U << 20;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

ConfigReading Refuse(const std::string& path, const std::string& message) {
  return {std::nullopt, {{path, 0, 0, Severity::kError, message}}};
}

ConfigReading RefuseSize(const std::string& path) {
  return Refuse(path, "the file is too large: expected a state config of at most 8 MiB");
}

constexpr std::array<std::string_view, 12> kSections = {
    "controller", "actuator", "state",      "transition", "transport", "security",
    "safety",     "policy",   "capability", "ros2",       "view",      "host"};

bool IsSection(const Value& value) {
  const auto* array = value.As<Array>();
  return value.As<Table>() != nullptr ||
         (array != nullptr && !array->empty() && array->front().As<Table>() != nullptr);
}

// Corrects the section names that are plainly typing errors.
void PutSectionNamesRight(Table& table, Draft& draft) {
  const std::vector<std::string_view> sections(kSections.begin(), kSections.end());
  for (Member& member : table) {
    if (std::find(sections.begin(), sections.end(), member.key) != sections.end()) continue;
    const std::string meant = Nearest(member.key, sections);
    if (meant.empty() || Find(table, meant) != nullptr || !IsSection(member.value)) continue;
    if (meant != "controller") {  // NotAStateConfig() has reported that
      draft.findings.Error(member.at,
                           "unknown key " + Quote(member.key) + DidYouMean(Quote(meant)));
    }
    member.key = meant;
  }
}

// Reports what the file has instead of a [controller] table.
SyntaxFault NotAStateConfig(const Table& root) {
  const std::string message = "not a state config: expected a [controller] table, found ";
  if (root.empty()) return {{}, message + "an empty file"};
  const Member* shown = nullptr;
  for (const Member& member : root) {
    const bool is_slip = !Nearest(member.key, std::vector<std::string_view>{"controller"}).empty();
    const bool is_table = member.value.As<Table>() != nullptr;
    if (is_slip && is_table) {
      return {member.at, message + "[" + member.key + "]" + DidYouMean("\"controller\"")};
    }
    if (is_table && shown == nullptr) shown = &member;
  }
  if (shown != nullptr) return {shown->at, message + "[" + shown->key + "]"};
  return {root.front().at, message + "the key " + Quote(root.front().key)};
}

void ReadSections(const Table& table, Draft& draft) {
  TableReader root(table, {1, 1}, "", draft.findings);
  for (const std::string_view section : kSections) root.Get(section);
  root.RefuseOthers();
  ReadOwnStates(root, draft);
  ReadController(root, draft);
  ReadTransitions(root, draft);
  ReadTransport(root, draft);
  CheckFailover(draft);
  ReadSecurity(root, draft);
  ReadSafety(root, draft);
  WarnOfSharedNetwork(draft);
  ReadView(root, draft);
  ReadPolicy(root, draft);
  ReadRos2(root, draft);
  ReadHosts(root, draft);
  ReadActuators(root, draft);
  WarnOfUnusedHosts(root, draft);
  ReadCapabilities(root, draft);
}

void ReadDocument(Table& table, Draft& draft) {
  if (config_toml::Find(table, "controller") == nullptr) {
    const SyntaxFault fault = NotAStateConfig(table);
    draft.findings.Error(fault.at, fault.message);
  }
  PutSectionNamesRight(table, draft);
  if (config_toml::Find(table, "controller") != nullptr) ReadSections(table, draft);
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

  auto document = config_toml::ParseDocument(text);
  if (auto* table = std::get_if<Table>(&document)) {
    ReadDocument(*table, draft);
  } else {
    const auto& fault = std::get<SyntaxFault>(document);
    draft.findings.Error(fault.at, fault.message);
  }
  ConfigReading reading;
  (draft.findings.HasErrors() ? reading.faulty : reading.config) = std::move(draft.config);
  reading.diagnostics = std::move(draft.findings).Take(path, text);
  return reading;
}

ConfigReading ReadConfigFile(const std::string& path) {
  const Result<std::string> text = config_toml::ReadTextFile(path, kLargestFile);
  return text ? ReadConfigText(text.value(), path) : Refuse(path, text.error().message);
}

}  // namespace musher
