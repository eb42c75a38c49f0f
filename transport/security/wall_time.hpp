#pragma once
// The times of certificates and permissions.

#include <chrono>

namespace musher::transport::keys {

using WallTime = std::chrono::sys_seconds;

}  // namespace musher::transport::keys
