#pragma once
// Where machines run on this host: a person there who does not say which machine is meant means the
// one that runs here, in whatever namespace, and no other one in range.
//
// Threads: any; reads the kernel's table of sockets. MachineFolders() reads the disk.

#include <compare>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "musher/controller/storage/machine_origin.hpp"

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

// What a person or a program says of where its machine is.
struct MeantPlace {
  MachinePlace own;              // where it speaks to a machine
  bool names_namespace = false;  // expressly: then no other namespace is meant …
  bool names_domain = false;     // … and no other domain

  // Whether a machine there, beside the own place, may be meant.
  bool MayBe(const MachinePlace& place) const;
};

// The places in `running` that a stop without an express name has to reach beside its own place: in
// its domain; if nothing runs there, in the others. `has_files`: whether a machine has files on the
// host, called for other domains only: a colleague's simulation has none.
std::vector<MachinePlace> PlacesToStop(const MeantPlace& meant,
                                       const std::vector<MachinePlace>& running,
                                       const std::function<bool(const MachinePlace&)>& has_files);

// The state folders of machines that were started on this computer by a config that is still
// there: of robot.toml in the working directory, and in the default places.
using MachineFolder = std::pair<std::string, MachineOrigin>;
std::vector<MachineFolder> MachineFolders();
bool HasFolder(const std::vector<MachineFolder>& folders, const MachinePlace& place);

// Why a program that was given neither a machine nor a namespace acts on none of another host:
// "the machine of this host runs in namespace 'dogA', …". "": of `places` none is in the domain
// beside the program's own.
std::string WhyNotFrom(const MachinePlace& own, const std::vector<MachinePlace>& places,
                       const std::string& found);

}  // namespace musher
