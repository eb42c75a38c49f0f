#pragma once
// How another host of the machine is reached: the arguments of ssh, and what to do about what it
// says when it fails.
//
// Threads: any.

#include <string>
#include <vector>

#include "musher/lifecycle/config/config.hpp"

namespace musher {

// The arguments of ssh for such a host, up to the command; nothing is asked, and no connection is
// shared. Empty texts: ssh chooses.
std::vector<std::string> SshArguments(const HostConfig& host);

struct SshTrouble {
  std::string text;       // why, with what to do
  bool for_good = false;  // it does not help to try again, such as a key that is refused
};
// `why`: the words of ssh, or of its user.
SshTrouble SshTroubleOf(const std::string& why, const std::string& login);

// What ssh has said last.
std::string LastLineOf(const std::string& errors);

}  // namespace musher
