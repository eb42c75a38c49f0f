#include "musher/cli/deploy/deploy_plan.hpp"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "musher/base/joined.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/ota/manifest.hpp"
#include "musher/transport/security/key_folder.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCurrentLink = "/current";

// A path in a slot that a word names.
struct SlotPath {
  std::string root;
  std::string path;  // empty: the slot itself
};

std::optional<SlotPath> SlotPathIn(const std::string& word) {
  const std::size_t begin = word.find('/');
  if (begin == std::string::npos) return std::nullopt;
  const std::string text = fs::path(word.substr(begin)).lexically_normal().string();
  for (std::size_t at = text.find(kCurrentLink); at != std::string::npos;
       at = text.find(kCurrentLink, at + 1)) {
    const std::size_t end = at + kCurrentLink.size();
    if (at == 0 || (end < text.size() && text[end] != '/')) continue;
    return SlotPath{text.substr(0, at), end + 1 < text.size() ? text.substr(end + 1) : ""};
  }
  return std::nullopt;
}

// The parts of "/opt/robot/current/lib:/usr/lib".
std::vector<std::string> PathsOf(const std::string& value) {
  std::vector<std::string> paths;
  std::istringstream stream(value);
  for (std::string path; std::getline(stream, path, ':');) paths.push_back(path);
  return paths;
}

// In PEM, as all of openssl, ssh and `musher ota keygen` are; also inside of JSON and YAML.
bool HoldsPrivateKey(const std::string& file) {
  constexpr std::size_t kRead = 1 << 20;  // bytes; a key comes early, after certificates at most
  constexpr std::string_view kBefore = "\n\r\t \"'";  // in a program it stands behind a NUL
  std::string text(kRead, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  constexpr std::string_view kBegin = "-----BEGIN";
  for (std::size_t at = text.find(kBegin); at != std::string::npos;
       at = text.find(kBegin, at + 1)) {
    if (at != 0 && kBefore.find(text[at - 1]) == std::string_view::npos) continue;
    const std::string line = text.substr(at, text.find('\n', at) - at);
    if (line.find("PRIVATE KEY") != std::string::npos) return true;
  }
  return false;
}

class Planner {
 public:
  Planner(const MachineConfig& config, std::string from) : config_(config), from_(std::move(from)) {
    folder_ = fs::absolute(config.file).lexically_normal().parent_path();
  }

  Result<DeployPlan> Run() {
    for (const HostConfig& host : config_.hosts) {
      host_ = HostFiles{&host, "", {}, {}};
      for (const ActuatorConfig& actuator : config_.actuators) {
        if (actuator.host == host.name) Take(actuator);
      }
      if (!host_.root.empty()) plan_.hosts.push_back(std::move(host_));
    }
    if (!errors_.empty()) return Error{kCodeParametersInvalid, errors_};
    if (!plan_.hosts.empty()) return plan_;
    return Error{kCodeParametersInvalid,
                 config_.file +
                     ": no actuator of another host is started from an upgrade root; name its "
                     "program as ROOT/current/PROGRAM, such as /opt/robot/current/bin/eyes"};
  }

 private:
  void Take(const ActuatorConfig& actuator) {
    bool in_root = false;
    bool has_config = false;
    config_folder_.clear();
    const auto take = [&](const std::string& word, bool is_config) {
      const auto named = SlotPathIn(word);
      if (!named || !TakeRoot(actuator, named->root)) return;
      in_root = true;
      has_config |= is_config;
      if (named->path.empty()) return;
      if (is_config) config_folder_ = fs::path(named->path).parent_path();
      is_config ? Put(actuator, named->path, config_.file) : Find(actuator, named->path, true);
    };
    for (const std::string& word : actuator.command) take(word, false);
    for (const auto& [name, value] : actuator.env) {
      for (const std::string& part : PathsOf(value)) take(part, name == "MUSHER_CONFIG");
    }
    const auto cwd = SlotPathIn(actuator.cwd);
    if (cwd && TakeRoot(actuator, cwd->root)) {
      in_root = true;
      for (std::size_t i = 0; i < actuator.command.size(); ++i) {
        const std::string& word = actuator.command[i];
        const bool in_path = i == 0 && word.find('/') == std::string::npos;
        if (word.empty() || word.front() == '/' || word.front() == '-' || in_path) continue;
        // A word may be a path, or not.
        Find(actuator, (fs::path(cwd->path) / word).lexically_normal().string(), i == 0);
      }
    }
    if (!in_root) return;
    host_.actuators.push_back(actuator.name);
    if (!has_config) {
      plan_.notes.push_back(fmt::format(
          "{} reads the config at {} on host {}, where it is not copied to; env.MUSHER_CONFIG = "
          "\"{}/current/{}\" names it in the slot",
          actuator.name, fs::absolute(config_.file).lexically_normal().string(), actuator.host,
          host_.root, fs::path(config_.file).filename().string()));
    }
    if (has_config) TakeRules(actuator);
    TakeKeys(actuator);
  }

  bool TakeRoot(const ActuatorConfig& actuator, const std::string& root) {
    if (host_.root.empty()) host_.root = root;
    if (host_.root == root) return true;
    Refuse(actuator,
           fmt::format("it is in {}, and others of host {} are in {}; a host has one root", root,
                       actuator.host, host_.root));
    return false;
  }

  void Find(const ActuatorConfig& actuator, const std::string& path, bool needed) {
    std::error_code error;
    const fs::path own = fs::path(from_) / actuator.host / path;
    const fs::path common = fs::path(from_) / path;
    const fs::path found = fs::exists(own, error) ? own : common;
    if (!fs::exists(found, error)) {
      if (needed) {
        Refuse(actuator, fmt::format("{} is neither in {} nor in {}", path,
                                     (fs::path(from_) / actuator.host).string(), from_));
      }
      return;
    }
    if (!fs::is_directory(found, error)) return PutNamed(actuator, path, found.string());
    for (auto at = fs::recursive_directory_iterator(found, error);
         !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
      if (at->is_symlink(error) && !at->is_regular_file(error)) NoteLink(at->path());
      if (!at->is_regular_file(error) || IsSecret(at->path())) continue;
      Put(actuator, (path / at->path().lexically_relative(found)).lexically_normal().string(),
          at->path().string());
    }
    if (error) Refuse(actuator, found.string() + ": " + error.message());
  }

  // A link to a file is copied as that file; a program may need what one to a folder leads to.
  void NoteLink(const fs::path& link) {
    if (!noted_.insert(link).second) return;
    plan_.notes.push_back(link.string() +
                          " is not copied: it is a link to a folder, or to nothing");
  }

  bool IsInKeys(const fs::path& file) const {
    if (config_.keys.empty()) return false;
    std::error_code error;
    const fs::path inside = fs::weakly_canonical(file, error)
                                .lexically_relative(fs::weakly_canonical(config_.keys, error));
    return !inside.empty() && *inside.begin() != "..";
  }

  // Of a file in a folder that a word names. TakeKeys() alone copies keys.
  bool IsSecret(const fs::path& file) {
    if (IsInKeys(file)) return true;
    if (!HoldsPrivateKey(file)) return false;
    if (noted_.insert(file).second) {
      plan_.notes.push_back(file.string() + " is not copied: it is a private key");
    }
    return true;
  }

  // A file that a word names.
  void PutNamed(const ActuatorConfig& actuator, const std::string& path,
                const std::string& source) {
    if (IsInKeys(source)) {
      std::error_code error;
      for (const std::string& own : KeysOf(actuator)) {
        if (fs::equivalent(own, source, error)) return;
      }
      return Refuse(actuator, source + " is none of its own keys, which alone are copied");
    }
    if (HoldsPrivateKey(source)) {
      return Refuse(actuator, source +
                                  " is a private key, and no key but its own of `musher keys` is "
                                  "copied; put it on the host yourself, outside of " +
                                  host_.root);
    }
    Put(actuator, path, source);
  }

  std::vector<std::string> KeysOf(const ActuatorConfig& actuator) const {
    const transport::keys::KeyFolder keys(config_.keys);
    return {keys.IdentityCa(),
            keys.PermissionsCa(),
            keys.Governance(),
            keys.Revocations(),
            keys.Certificate(actuator.name),
            keys.Permissions(actuator.name),
            keys.Key(actuator.name)};
  }

  void TakeKeys(const ActuatorConfig& actuator) {
    if (config_.keys.empty()) return;
    const std::string& user = actuator.limits.user;
    if (!user.empty() && user != host_.host->user) {
      return Refuse(actuator,
                    fmt::format("its limits.user {} could not read its key, which belongs to the "
                                "login of host {}; leave out limits.user, or set host.{}.user = "
                                "\"{}\"",
                                user, host_.host->name, host_.host->name, user));
    }
    const fs::path inside = fs::path(config_.keys).lexically_relative(folder_);
    if (inside.empty() || *inside.begin() == "..") {
      return Refuse(actuator, "its keys are in " + config_.keys + ", which is not below " +
                                  folder_.string() + ": they have no place in a slot");
    }
    const std::string revocations = transport::keys::KeyFolder(config_.keys).Revocations();
    for (const std::string& file : KeysOf(actuator)) {
      std::error_code error;
      if (!fs::exists(file, error)) {
        if (file != revocations) Refuse(actuator, file + " is missing; see `musher keys`");
        continue;
      }
      // Where the process looks for them: the config names them from its own folder.
      Put(actuator, (config_folder_ / inside / fs::path(file).filename()).string(), file);
    }
  }

  // No actuator needs them; the config in the slot names them.
  void TakeRules(const ActuatorConfig& actuator) {
    const std::string& rules = config_.rules_file;
    if (rules.empty()) return;
    std::error_code error;
    const bool exists = fs::is_regular_file(rules, error);
    const std::string below = RulesBelow(config_, folder_.string());
    if (exists && !below.empty()) {
      const std::string path = (config_folder_ / below).string();
      // A file of this path that an actuator names goes before.
      if (!host_.files.contains(path)) PutNamed(actuator, path, rules);
      return;
    }
    if (!noted_.insert(rules).second) return;
    plan_.notes.push_back(rules + ", which [safety] rules names, is not copied: " +
                          (exists ? "it is not below " + folder_.string() : "it is missing here"));
  }

  void Put(const ActuatorConfig& actuator, const std::string& path, const std::string& source) {
    if (const auto fault = ota::PathFault(path)) return Refuse(actuator, path + ": " + *fault);
    host_.files[path] = source;
  }

  void Refuse(const ActuatorConfig& actuator, const std::string& what) {
    errors_ += (errors_.empty() ? "" : "\n") + ("actuator." + actuator.name) + ": " + what;
  }

  const MachineConfig& config_;
  std::string from_;
  fs::path folder_;
  fs::path config_folder_;  // of the config in the slot, of one actuator
  HostFiles host_;
  DeployPlan plan_;
  std::set<fs::path> noted_;
  std::string errors_;
};

}  // namespace

Result<DeployPlan> PlanDeployment(const MachineConfig& config, const std::string& from) {
  return Planner(config, from).Run();
}

std::string ProcessorOf(const std::string& file) {
  constexpr std::size_t kMachine = 18;
  std::array<char, kMachine + 2> begin{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(begin.data(), begin.size())) return {};
  if (std::string_view(begin.data(), 4) !=
      "\x7f"
      "ELF") {
    return {};
  }
  return fmt::format("{:02x} {:02x}", static_cast<unsigned char>(begin[kMachine]),
                     static_cast<unsigned char>(begin[kMachine + 1]));
}

}  // namespace musher::cli
