#pragma once
// The result of the last self-check of a start, in a file that survives the controller:
// `last_selfcheck_info.json` in the controller's folder, the description of `self_check_status`.
//
// Threads: loop thread only.

#include <functional>
#include <string>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::cyberdog {

// Saves a small file of the controller's folder without waiting for the disk.
using SaveText = std::function<void(const std::string& name, const std::string& text)>;

class SelfCheckFile {
 public:
  inline static constexpr const char* kName = "last_selfcheck_info.json";
  inline static constexpr Duration kDelay = std::chrono::seconds(2);  // as CyberDog's manager

  // All must outlive it; `save` may be empty.
  SelfCheckFile(transport::EventLoop& loop, const MachineConfig& config, const Machine& machine,
                SaveText save)
      : loop_(loop), config_(config), machine_(machine), save_(std::move(save)) {}

  // Call for every record. Saves once, when start-up is complete; not for a controller that
  // adopts a running machine, since it has checked nothing.
  void OnRecord();

 private:
  transport::EventLoop& loop_;
  const MachineConfig& config_;
  const Machine& machine_;
  const SaveText save_;
  bool ended_ = false;  // the start
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::cyberdog
