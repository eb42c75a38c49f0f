#include "musher/base/user.hpp"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "musher/base/host.hpp"

namespace musher {

std::string UserAtHostAtOnce() {
  const std::string own = std::to_string(getuid());
  std::ifstream users("/etc/passwd");  // "alice:x:1000:1000::/home/alice:/bin/sh"
  for (std::string line; std::getline(users, line);) {
    std::istringstream fields(line);
    std::string name;
    std::string password;
    std::string uid;
    std::getline(std::getline(std::getline(fields, name, ':'), password, ':'), uid, ':');
    if (uid == own) return name + "@" + HostName();
  }
  const char* login = std::getenv("LOGNAME");  // NOLINT(concurrency-mt-unsafe)
  return (login != nullptr && *login != '\0' ? login : own) + "@" + HostName();
}

}  // namespace musher
