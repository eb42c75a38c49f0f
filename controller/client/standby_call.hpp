#pragma once
// The report of a standby to the commands of its host: that it stands by, and why it does not lead.
// By a socket of the kernel, so that they receive it also where no controller and no network
// answers. A standby publishes nothing to other hosts.
//
// Each user of the host may read it, also with credentials: it has no more than its systemd unit
// shows.
//
// Threads: loop thread only.

#include <sys/types.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/host_calls.hpp"

namespace musher {

// As of a NameLock.
std::string StandbyName(int domain, std::string_view name_space);

struct StandbyReport {
  MachineIdentity machine;
  std::string why_not;  // it does not lead; "": it does in a moment
  pid_t pid = 0;

  friend bool operator==(const StandbyReport&, const StandbyReport&) = default;
};

class StandbyServer {
 public:
  // `report`: without the pid, which the kernel knows.
  static Result<std::unique_ptr<StandbyServer>> Make(transport::EventLoop& loop,
                                                     const std::string& name,
                                                     std::function<StandbyReport()> report);

 private:
  explicit StandbyServer(std::unique_ptr<transport::HostServer> server)
      : server_(std::move(server)) {}
  std::unique_ptr<transport::HostServer> server_;
};

class StandbyCall {
 public:
  // Null: none stands by on this host.
  static std::unique_ptr<StandbyCall> Make(transport::EventLoop& loop, const std::string& name);

  bool ended() const { return ended_; }
  // nullopt: it has ended without an answer, since it leads now or has exited. Before ended(): that
  // it does not answer.
  std::optional<StandbyReport> Report() const;

 private:
  StandbyCall() = default;
  std::unique_ptr<transport::HostCall> call_;
  pid_t pid_ = 0;
  bool ended_ = false;
  std::optional<StandbyReport> report_;
};

}  // namespace musher
