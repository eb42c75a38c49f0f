#pragma once
// Reports when an interface to other hosts has come, or got another address, since this process has
// joined its DDS domain: Cyclone keeps the interfaces of the start, so only a new process uses it.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "musher/base/unique_fd.hpp"
#include "musher/transport/event_loop.hpp"
#include "musher/transport/network.hpp"

namespace musher::transport {

class NetworkWatch {
 public:
  using OnMissed = std::function<void(const std::string& missed)>;  // "wlan0 with 10.0.0.7"

  // `configured`: as of ChooseInterfaces(). Null where the kernel reports no changes.
  static std::unique_ptr<NetworkWatch> Make(EventLoop& loop, std::vector<std::string> configured,
                                            OnMissed on_missed);

 private:
  NetworkWatch(EventLoop& loop, std::vector<std::string> configured, OnMissed on_missed,
               UniqueFd kernel);
  void OnChange();
  void Compare();

  EventLoop& loop_;
  const std::vector<std::string> configured_;
  const OnMissed on_missed_;
  const std::vector<NetworkInterface> at_start_ = ReadInterfaces();
  std::set<std::string> reported_;  // each once
  UniqueFd kernel_;
  LoopHandlePtr changed_;
  LoopHandlePtr compare_later_;
};

}  // namespace musher::transport
