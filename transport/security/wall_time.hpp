#pragma once
// The times of certificates and permissions.

#include <chrono>
#include <string>

namespace musher::transport::keys {

using WallTime = std::chrono::sys_seconds;
std::string IsoTime(WallTime time);  // "2026-01-31T12:00:00Z"

}  // namespace musher::transport::keys
