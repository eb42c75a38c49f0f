#include "musher/controller/process/own_systemd.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>

#include "musher/base/files.hpp"
#include "musher/controller/process/child_processes.hpp"

namespace musher {
namespace {

constexpr std::string_view kSocketAddress = "unix:path=";
// The folder exists where systemd has booted the system (sd_booted(3)).
constexpr const char* kBootedBySystemd = "/run/systemd/system";

std::string ValueOf(const std::map<std::string, std::string>& environment,
                    const std::string& name) {
  const auto found = environment.find(name);
  return found == environment.end() ? "" : found->second;
}

// The path in "unix:path=/run/dbus/system_bus_socket,guid=…"; empty: it names none.
std::string SocketIn(std::string_view address) {
  if (!address.starts_with(kSocketAddress)) return {};
  address.remove_prefix(kSocketAddress.size());
  return std::string(address.substr(0, address.find_first_of(",;")));
}

bool Exists(const std::string& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

// What systemd accepts for the environment of a unit: text, without control characters but tabs and
// newlines. Bytes beyond ASCII are taken as they are if they are UTF-8.
bool IsText(std::string_view value) {
  int follow = 0;
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (follow > 0) {
      if ((byte & 0xC0U) != 0x80U) return false;
      --follow;
    } else if (byte >= 0xF0U && byte < 0xF5U) {
      follow = 3;
    } else if (byte >= 0xE0U && byte < 0xF0U) {
      follow = 2;
    } else if (byte >= 0xC2U && byte < 0xE0U) {
      follow = 1;
    } else if (byte >= 0x7FU || (byte < 0x20U && byte != '\t' && byte != '\n')) {
      return false;
    }
  }
  return follow == 0;
}

bool IsVariable(std::string_view name) {
  const auto allowed = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  return !name.empty() && std::isdigit(static_cast<unsigned char>(name.front())) == 0 &&
         std::ranges::all_of(name, allowed);
}

// What systemd has given to this process alone.
const std::set<std::string>& OfThisProcessAlone() {
  static const std::set<std::string> names = {
      "NOTIFY_SOCKET", "WATCHDOG_USEC",  "WATCHDOG_PID",     "LISTEN_PID",
      "LISTEN_FDS",    "LISTEN_FDNAMES", "MAINPID",          "MANAGERPID",
      "INVOCATION_ID", "JOURNAL_STREAM", "SYSTEMD_EXEC_PID", "CREDENTIALS_DIRECTORY",
      kChildMark};
  return names;
}

// Whether a variable belongs to the user of this process: another user has another value.
bool IsOfUser(std::string_view name) {
  static const std::set<std::string_view> names = {"HOME",  "USER", "LOGNAME",
                                                   "SHELL", "MAIL", "DBUS_SESSION_BUS_ADDRESS"};
  return names.contains(name) || name.starts_with("XDG_");
}

}  // namespace

OwnSystemd FindOwnSystemd(const std::map<std::string, std::string>& environment, uid_t user) {
  OwnSystemd found;
  if (user == 0) {
    const std::string named = ValueOf(environment, "DBUS_SYSTEM_BUS_ADDRESS");
    if (!named.empty()) {
      found.socket = SocketIn(named);
      if (found.socket.empty()) {
        found.trouble = "DBUS_SYSTEM_BUS_ADDRESS names no socket of this host; unset it";
      }
    } else if (!Exists(kBootedBySystemd)) {
      found.trouble = "systemd does not run on this host (no " + std::string(kBootedBySystemd) +
                      "); start the machine where it does, or remove `units`";
    } else {
      found.socket = "/run/dbus/system_bus_socket";
    }
    if (found.trouble.empty() && !Exists(found.socket)) {
      found.trouble = "D-Bus does not run on this host (no " + found.socket +
                      "); install the package dbus, or remove `units`";
    }
    return found;
  }
  const std::string id = std::to_string(user);
  const std::string named = SocketIn(ValueOf(environment, "DBUS_SESSION_BUS_ADDRESS"));
  const std::string folder = ValueOf(environment, "XDG_RUNTIME_DIR");
  found.socket = !named.empty() ? named : (folder.empty() ? "/run/user/" + id : folder) + "/bus";
  if (!Exists(found.socket)) {
    found.trouble = "no systemd of user " + id + " runs (no " + found.socket +
                    "); `loginctl enable-linger " + id +
                    "` starts it with the host, and needs the package dbus-user-session; or start "
                    "the machine as root, or remove `units`";
  }
  return found;
}

// "0::/system.slice/musher-robot-arm.service"; in a hierarchy of version 1 "1:name=systemd:/…".
std::string UnitOf(pid_t pid) {
  std::istringstream lines(ReadFile("/proc/" + std::to_string(pid) + "/cgroup"));
  for (std::string line; std::getline(lines, line);) {
    const bool is_systemds =
        line.starts_with("0::") || line.find(":name=systemd:") != std::string::npos;
    const bool is_unit = line.ends_with(".service") || line.ends_with(".scope");
    if (is_systemds && is_unit) return line.substr(line.rfind('/') + 1);
  }
  return {};
}

void InheritForUnit(const std::map<std::string, std::string>& environment, ProcessSpec& spec) {
  for (const auto& [name, value] : environment) {
    if (!IsVariable(name) || !IsText(value) || OfThisProcessAlone().contains(name)) continue;
    if (!spec.limits.user.empty() && IsOfUser(name)) continue;
    spec.env.emplace(name, value);
  }
  std::error_code error;
  // '-': another user, or a sandbox, may not enter it, and then starts in '/'.
  const std::filesystem::path here = std::filesystem::current_path(error);
  if (spec.cwd.empty() && !here.empty()) spec.cwd = "-" + here.string();
  // A stalled disk may hold up a search in PATH, and the loop does not wait for it.
  const bool searched = spec.argv.front().find('/') == std::string::npos;
  if (searched) spec.argv.insert(spec.argv.begin(), "/usr/bin/env");
}

}  // namespace musher
