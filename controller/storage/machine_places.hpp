#pragma once
// Where machines run on this host: a person there who does not say which machine is meant means the
// one that runs here, in whatever namespace, and no other one in range.
//
// Threads: any; reads the kernel's table of sockets.

#include <compare>
#include <string>
#include <vector>

namespace musher {

// Where the processes of a machine find each other.
struct MachinePlace {
  int domain = 0;
  std::string name_space;

  // "namespace 'dogA'", with the domain where it is another one than the caller's.
  std::string Text(int own_domain) const;
  // "--namespace dogA", with --domain where that differs.
  std::string Options(const MachinePlace& own) const;

  friend auto operator<=>(const MachinePlace&, const MachinePlace&) = default;  // NOLINT(*-nullptr)
};

// Where a controller or an actuator runs on this host; sorted.
std::vector<MachinePlace> PlacesHere();

// Why a program that was given neither a machine nor a namespace acts on none of another host:
// "the machine of this host runs in namespace 'dogA', …". "": of `places` none is in the domain
// beside the program's own.
std::string WhyNotFrom(const MachinePlace& own, const std::vector<MachinePlace>& places,
                       const std::string& found);

}  // namespace musher
