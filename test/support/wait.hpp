#pragma once
// Waiting for an event, with a deadline far longer than the event takes.

#include <functional>
#include <string>

#include "musher/base/time.hpp"

namespace musher::testing {

// So long from now.
Time In(Duration duration);

// Waits until a descriptor is readable, or its other end is closed.
bool AwaitReadable(int descriptor, Time deadline);

// Waits until `holds`, which reads files of the folder: it is asked now, and after each change of a
// file there; for half a minute at most.
bool AwaitChange(const std::string& folder, const std::function<bool()>& holds);
// Waits until the file exists, in a folder that may be missing yet; for half a minute at most.
bool AwaitFile(const std::string& path);

// Waits until `holds`, which is asked every millisecond: for a value that changes without an event
// to wait for.
bool Until(const std::function<bool()>& holds, Duration limit = std::chrono::seconds(120));

}  // namespace musher::testing
