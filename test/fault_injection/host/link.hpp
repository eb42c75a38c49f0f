#pragma once
// A network link between two network namespaces of this machine: an interface at each end, and a
// thread between them that loses, delays, duplicates and reorders packets.
//
// The kernel's netem does the same where it is available. This needs /dev/net/tun only, and its
// random numbers follow a seed.
//
// Threads: any. Errors: throws std::system_error.

#include <sys/types.h>

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/test/fault_injection/random.hpp"

namespace musher::fault_injection {

// Of one direction.
struct LinkImpairment {
  int loss_percent = 0;  // 100: cut
  int duplicate_percent = 0;
  Duration delay{};
  Duration jitter{};  // at random up to this for each packet, which reorders them
};

class Link {
 public:
  static constexpr const char* kInterface = "link";
  static constexpr const char* kHere = "10.77.0.1";
  static constexpr const char* kThere = "10.77.0.2";

  // Links this network namespace with that of the process `there`.
  explicit Link(pid_t there);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void Set(const LinkImpairment& to_there, const LinkImpairment& to_here, std::uint64_t seed);
  void Heal() { Set({}, {}, 0); }
  // The interface of one end.
  void LinkDown(bool there);
  void LinkUp(bool there);

 private:
  struct Packet {
    int to;
    std::vector<char> bytes;
  };

  void Run();
  void Take(int from, int to, const LinkImpairment& impairment);
  void Deliver();
  void InThere(const std::function<void()>& work) const;

  const pid_t there_;
  UniqueFd here_fd_;
  UniqueFd there_fd_;
  UniqueFd wake_;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;  // guards what follows
  LinkImpairment to_there_;
  LinkImpairment to_here_;
  Random random_{0};
  std::multimap<Time, Packet> under_way_;  // of the thread alone
  std::thread thread_;                     // last: it uses all of the above
};

}  // namespace musher::fault_injection
