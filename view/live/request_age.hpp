#pragma once
// Whether a request of a page came too late to be obeyed: a wifi that was lost delivers it half a
// minute later, and the person has long looked elsewhere. The age is measured by one clock: the
// server sends its time each second, and a request brings back the newest one that its page has.
//
// Pure. Threads: any.

#include <cstdint>
#include <string>

#include "musher/base/result.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"

namespace musher::view {

// A page gets the time each second; a request on a bad connection takes some seconds more.
inline constexpr std::int64_t kMostAgeMs = 5000;

// `seen_ms`: the newest time of the server that the page had; both are milliseconds since the boot
// of the server's host, also while it was suspended. Fails with kCodeStateInvalid and a sentence
// for the person if what the page shows is older than kMostAgeMs, or of another boot.
Result<> CheckAge(std::int64_t seen_ms, std::int64_t now_ms);

// Whether a switch to `target` leads down and raises no actuator of that machine (RaisesNothing()
// in lifecycle/state.hpp, as for the controller): such a request is obeyed, however late it comes.
// `actuator` empty: of the whole machine. False where a state of the config is concerned, since
// only the controller knows its rank, and for an actuator in Error, which the controller may leave
// out.
bool OnlyLowers(const msg::MachineStatus& status, const std::string& target,
                const std::string& actuator);

}  // namespace musher::view
