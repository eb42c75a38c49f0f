#pragma once
// Discovery: matches writers with readers and notifies each side of each match and of its loss,
// also because of a blocked link.
//
//   a side:  unaware --discovers after its delay--> aware --lease over, crash, deletion--> unaware
//                ^-- a blocked link keeps it unaware until the link is unblocked --^

#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "musher/transport/sim/channel.hpp"
#include "musher/transport/sim/links.hpp"
#include "musher/transport/sim/random.hpp"
#include "musher/transport/sim/scheduler.hpp"

namespace musher::transport::sim {

class Delivery;

class Discovery {
 public:
  Discovery(Scheduler& scheduler, Links& links, Random& random, Delivery& delivery)
      : scheduler_(scheduler), links_(links), random_(random), delivery_(delivery) {}

  // The discovery delay of a side, and the time after which a silent participant is lost.
  void SetDelay(Duration least, Duration most);
  // The same between processes of that host and all others, and among them.
  void SetDelayOf(HostId host, Duration least, Duration most) { delays_of_[host] = {least, most}; }
  void SetLease(Duration lease) { lease_ = lease; }

  void Add(const std::string& topic, const std::string& type,
           const std::shared_ptr<WriterEnd>& writer);
  void Add(const std::string& topic, const std::string& type,
           const std::shared_ptr<ReaderEnd>& reader);
  // Drops an end and notifies the others.
  void Close(End& end) { Close(end, {}, false); }
  // Drops all ends of a process; the others notice when the lease expires.
  void Crash(ProcessId process);

  // After a link was blocked or unblocked.
  void LinkChanged(HostId from, HostId to);

 private:
  struct Topic {
    std::vector<std::shared_ptr<WriterEnd>> writers;
    std::vector<std::shared_ptr<ReaderEnd>> readers;
  };

  std::pair<Duration, Duration> DelayBetween(HostId a, HostId b) const;
  void Match(const std::shared_ptr<WriterEnd>& writer, const std::shared_ptr<ReaderEnd>& reader);
  void Discover(const std::shared_ptr<Channel>& channel, Side side);
  void Learn(const std::shared_ptr<Channel>& channel, Side side);
  bool AnEarlierOneIsUnknown(const Channel& channel, Side side) const;
  void ForgetAt(Time when, const std::shared_ptr<Channel>& channel, Side side, bool silent);
  void Forget(const std::shared_ptr<Channel>& channel, Side side);
  void ExpireLeases(HostId from, HostId to);
  void Remove(const std::shared_ptr<Channel>& channel);
  // Whether the link carries the other side's announcements to `side`.
  static bool ReceivesOver(const Channel& channel, Side side, HostId from, HostId to);
  bool Blocked(const Channel& channel, Side side) const;
  void Close(End& end, Time crash_noticed, bool crashed);

  Scheduler& scheduler_;
  Links& links_;
  Random& random_;
  Delivery& delivery_;
  Duration delay_min_ = Milliseconds(1);
  Duration delay_max_ = Milliseconds(5);
  std::map<HostId, std::pair<Duration, Duration>> delays_of_;
  Duration lease_ = std::chrono::seconds(10);

  std::map<std::pair<std::string, std::string>, Topic> topics_;
  std::vector<std::shared_ptr<Channel>> channels_;
  // Announcements from a process to another arrive in order, separately for writers and readers.
  std::map<std::tuple<ProcessId, ProcessId, Side>, Time> last_announcement_;
};

}  // namespace musher::transport::sim
