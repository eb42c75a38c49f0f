#include "musher/controller/process/ssh.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace musher {
namespace {

struct Cure {
  std::string_view sign;  // in what ssh says
  bool for_good = false;
  std::string_view cure;
};

// The first one whose sign is in ssh's words.
constexpr std::array kCures = {
    Cure{"Permission denied", true,
         "put the public key into ~/.ssh/authorized_keys of that user, and try `ssh {login} true`"},
    Cure{"Host key verification failed", true,
         "its key is not known here, or has changed: compare it, then put it into known_hosts (see "
         "ssh-keyscan)"},
    Cure{"Could not resolve", false, "correct its address"},
    Cure{"another host answers", false,
         "give each board its own address; if the board was replaced, restart the controller"},
    Cure{"does not say which host", false,
         "run `ssh {login} cat /proc/sys/kernel/random/boot_id`; the host may be out of memory"},
    Cure{"bus client", false,
         "its D-Bus does not run: boot it with systemd, and install dbus there; `ssh {login} "
         "systemctl status dbus.socket` shows it"},
    Cure{"systemd-stdio-bridge", true, "install systemd there; its processes need it"},
    Cure{"No such file or directory", true, "install openssh-client here"},
};
constexpr std::string_view kUsualCure =
    "check that it runs, and that `ssh {login} true` works without a question";

std::string WithLogin(std::string_view cure, const std::string& login) {
  std::string text(cure);
  constexpr std::string_view kPlace = "{login}";
  if (const std::size_t at = text.find(kPlace); at != std::string::npos) {
    text.replace(at, kPlace.size(), login);
  }
  return text;
}

}  // namespace

std::vector<std::string> SshArguments(const HostConfig& host) {
  std::vector<std::string> argv = {"ssh", "-xT"};
  for (const char* option :
       {"BatchMode=yes", "ConnectTimeout=5", "ServerAliveInterval=2", "ServerAliveCountMax=3",
        "ControlMaster=no", "ControlPath=none", "ForwardAgent=no", "ClearAllForwardings=yes"}) {
    argv.insert(argv.end(), {"-o", option});
  }
  if (!host.key.empty()) argv.insert(argv.end(), {"-i", host.key, "-o", "IdentitiesOnly=yes"});
  if (!host.known_hosts.empty())
    argv.insert(argv.end(), {"-o", "UserKnownHostsFile=\"" + host.known_hosts + "\""});
  if (!host.user.empty()) argv.insert(argv.end(), {"-l", host.user});
  argv.insert(argv.end(), {"--", host.address});
  return argv;
}

SshTrouble SshTroubleOf(const std::string& why, const std::string& login) {
  const auto* const cure = std::find_if(kCures.begin(), kCures.end(), [&](const Cure& one) {
    return why.find(one.sign) != std::string::npos;
  });
  const bool known = cure != kCures.end();
  return {
      why + (why.ends_with('.') ? " " : "; ") + WithLogin(known ? cure->cure : kUsualCure, login),
      known && cure->for_good};
}

std::string LastLineOf(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \r\n");
  if (end == std::string::npos) return {};
  const std::size_t begin = text.find_last_of("\r\n", end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

}  // namespace musher
