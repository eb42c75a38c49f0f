#include "musher/cli/doctor/lcm_facts.hpp"

#include <filesystem>
#include <string>
#include <variant>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/transport/lcm_socket.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli {
namespace {

constexpr const char* kProgram = "musher-motion-manager";

std::string TextOf(const config_toml::Table& table, const char* key) {
  const config_toml::Member* found = config_toml::Find(table, key);
  const auto* text = found == nullptr ? nullptr : found->value.As<std::string>();
  return text == nullptr ? "" : *text;
}

// Its [board], if that is on LCM.
std::optional<config_toml::Table> LcmBoardOf(const std::string& file) {
  const auto text = config_toml::ReadModuleText(file);
  if (!text) return std::nullopt;
  const auto document = config_toml::ParseDocument(text.value());
  const auto* root = std::get_if<config_toml::Table>(&document);
  const config_toml::Member* board = root == nullptr ? nullptr : config_toml::Find(*root, "board");
  const auto* keys = board == nullptr ? nullptr : board->value.As<config_toml::Table>();
  if (keys == nullptr || TextOf(*keys, "kind") != "lcm") return std::nullopt;
  return *keys;
}

// The file of the motion manager that the actuator runs; "": it runs another program.
std::string FileOf(const ActuatorConfig& actuator) {
  const auto& argv = actuator.command;
  if (argv.size() < 2 || !actuator.host.empty()) return "";
  if (std::filesystem::path(argv.front()).filename() != kProgram) return "";
  return (std::filesystem::path(actuator.cwd) / argv.back()).string();
}

}  // namespace

std::vector<LcmFacts> ReadLcm(const MachineConfig& config) {
  std::vector<LcmFacts> found;
  for (const ActuatorConfig& actuator : config.actuators) {
    const std::string file = FileOf(actuator);
    const auto board = file.empty() ? std::nullopt : LcmBoardOf(file);
    if (!board) continue;
    std::string text = TextOf(*board, "command_url");
    if (text.empty()) text = "udpm://239.255.76.67:7671";
    const auto url = transport::ReadLcmUrl(text);
    if (!url) continue;
    LcmFacts facts{actuator.name, file, url.value().group, TextOf(*board, "interface"), ""};
    transport::LinuxEventLoop loop;
    const auto opened = transport::LcmSocket::Open(loop, {url.value(), facts.network_interface, 1},
                                                   [](const transport::LcmSample&) {});
    if (!opened) facts.error = opened.error().message;
    found.push_back(std::move(facts));
  }
  return found;
}

}  // namespace musher::cli
