#pragma once
// Requests from a running musher-view of this host a link with which a person may log in.
//
// Threads: any; waits up to three seconds. Errors: a sentence; kCodeNetError if no process answers
// as musher-view does.

#include <cstdint>
#include <string>

#include "musher/base/result.hpp"

namespace musher::view {

// The path of the link: "/login?code=...". `token`: of its token file; `name`: of the person.
Result<std::string> RequestLink(const std::string& address, std::uint16_t port,
                                const std::string& token, const std::string& name);

}  // namespace musher::view
