#pragma once
// The options that every command of `musher` has.

#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::cli {

enum class ColourWhen { kAuto, kAlways, kNever };

struct GlobalOptions {
  bool json = false;
  std::string name_space;                // without outer '/'
  bool name_space_given = false;         // by --namespace, not by the environment
  std::string machine;                   // its name or the beginning of its id; empty: this host's
  std::optional<int> domain;             // none: ROS_DOMAIN_ID, else 0
  std::optional<std::string> transport;  // "local" or "lan"; none: MUSHER_TRANSPORT, else local
  std::vector<std::string> interfaces;   // to other hosts, of the profile lan; none: as DDS chooses
  std::optional<Duration> timeout;       // for the controller's answer; none: the command's own
  ColourWhen colour = ColourWhen::kAuto;
  std::string keys;      // folder with credentials; empty: none are used
  std::string identity;  // the name of the credentials
};

}  // namespace musher::cli
