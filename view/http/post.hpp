#pragma once
// One POST of JSON to a server of this host, for programs. Threads: any; waits for the reply.

#include <cstdint>
#include <string>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::http {

struct PostReply {
  unsigned status = 0;
  std::string body;
};

// `address`: "127.0.0.1". Fails with kCodeNetError if no HTTP server replies in time.
Result<PostReply> Post(const std::string& address, std::uint16_t port, const std::string& path,
                       const std::string& json, Duration timeout);

}  // namespace musher::http
