#pragma once
// A simulated network in memory and virtual time, for tests: the same decision code and the same
// Node interface, with injected delays, losses and crashes; the same seed gives the same run on
// every machine.
//
//   sim::Network network(seed);
//   auto dog = network.MakeNode("dog");
//   auto desk = network.MakeNode("desk");
//   network.Partition("dog", "desk");
//   network.RunFor(Milliseconds(500));
//
// Properties of DDS that it models: each side discovers a match at its own time; late joiners get a
// latched history; a reliable sample is delayed instead of lost and arrives after a partition, even
// if outdated; a silent process is lost after its lease.
//
// Threads: one. Nodes must be dropped before their network.

#include <functional>
#include <memory>
#include <string>

#include "musher/transport/node.hpp"
#include "musher/transport/sim/delivery.hpp"
#include "musher/transport/sim/discovery.hpp"
#include "musher/transport/sim/links.hpp"
#include "musher/transport/sim/random.hpp"
#include "musher/transport/sim/scheduler.hpp"

namespace musher::transport::sim {

class Network {
 public:
  explicit Network(std::uint64_t seed)
      : random_(seed),
        delivery_(scheduler_, links_, random_),
        discovery_(scheduler_, links_, random_, delivery_) {}
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  // A process of its own on that host; creates the host if necessary.
  std::unique_ptr<Node> MakeNode(const std::string& host);

  // Sets faults, at any time; they affect samples sent from now on.
  void SetFaults(const LinkFaults& faults) { links_.SetFaults(faults); }
  void SetFaults(const std::string& from, const std::string& to, const LinkFaults& faults);
  // Sets the faults of all links of that host, also to later hosts, in place of other faults.
  void SetFaultsOf(const std::string& host, const LinkFaults& faults) {
    links_.SetFaultsOf(links_.Host(host), faults);
  }
  // Blocks all samples from one host to the other, or both ways, until Free() or Heal().
  void Block(const std::string& from, const std::string& to) { SetBlocked(from, to, true); }
  void Free(const std::string& from, const std::string& to) { SetBlocked(from, to, false); }
  void Partition(const std::string& a, const std::string& b);
  void Heal(const std::string& a, const std::string& b);
  // The time until a process discovers a new writer or reader.
  void SetDiscoveryDelay(Duration least, Duration most) { discovery_.SetDelay(least, most); }
  void SetDiscoveryDelayOf(const std::string& host, Duration least, Duration most) {
    discovery_.SetDelayOf(links_.Host(host), least, most);
  }
  // A silent process is lost after half the lease to the whole lease.
  void SetLease(Duration lease) { discovery_.SetLease(lease); }
  // How far the steady clocks of a host's processes are ahead of the network's.
  void SetClockOffset(const std::string& host, Duration offset);

  // Called for every written sample, with the participant of its writer; may be empty.
  std::function<void(ParticipantId participant, const std::string& topic, const msg::Bytes&)>
      on_write;
  ParticipantId ParticipantOf(Node& node) const;

  // Crashes the process of a node: none of its callbacks runs any more. The node and the objects
  // made from it can still be dropped, and do nothing else.
  void Crash(Node& node);
  // Stops the process (SIGSTOP): its due events wait until Resume().
  void Pause(Node& node);
  void Resume(Node& node);

  Time now() const { return scheduler_.now(); }
  std::uint64_t steps() const { return scheduler_.steps(); }  // events run so far
  Random& random() { return random_; }

  // Runs the next event; false when there is none.
  // Whether a handler of a node runs now.
  bool running() const { return scheduler_.running(); }
  bool Step() { return scheduler_.Step(Time::max()); }
  void RunFor(Duration duration);
  // Until `done` holds (checked after every event) or the deadline is over; returns whether it
  // held.
  bool RunUntil(const std::function<bool()>& done, Time deadline);

 private:
  friend class SimNode;

  void SetBlocked(const std::string& from, const std::string& to, bool blocked);

  Scheduler scheduler_;
  Links links_;
  Random random_;
  Delivery delivery_;
  Discovery discovery_;
  std::uint64_t next_id_ = 1;
};

}  // namespace musher::transport::sim
