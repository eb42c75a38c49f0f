#pragma once
// Requests to a running musher-view of this host, which the token of its token file permits.
//
// Threads: any; each waits up to three seconds. Errors: a sentence; kCodeNetError if no process
// answers as musher-view does.

#include <cstdint>
#include <string>

#include "musher/base/result.hpp"
#include "musher/view/http/login.hpp"

namespace musher::view {

struct RunningView {
  std::string address;
  std::uint16_t port = 0;
  std::string token;
};

// A link with which the person of that name may log in.
Result<http::LoginLink> RequestLink(const RunningView& view, const std::string& name);
// Ends all logins.
Result<> RequestLogout(const RunningView& view);

}  // namespace musher::view
