#pragma once
// The processes that use /clock, and how far each has come: a world in lockstep waits until all of
// them have handled its last step. A process that exits or hangs is not waited for. Pure.
//
//   unknown --OnReached--> waited for --GiveUp--> given up --OnReached--> waited for
//
// Units: world time. Threads: one at a time.

#include <map>

#include "musher/base/time.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher::world {

class Followers {
 public:
  void OnReached(transport::EndpointId follower, Duration at) { reached_[follower] = at; }
  void OnLost(transport::EndpointId follower) { reached_.erase(follower); }

  // Whether all have handled the step of that time.
  bool Reached(Duration at) const {
    for (const auto& [follower, reached] : reached_) {
      if (reached < at) return false;
    }
    return true;
  }

  // Those that have not are not waited for until they reach a time again; returns their number.
  int GiveUp(Duration at) {
    return static_cast<int>(
        std::erase_if(reached_, [at](const auto& follower) { return follower.second < at; }));
  }

 private:
  std::map<transport::EndpointId, Duration> reached_;
};

}  // namespace musher::world
