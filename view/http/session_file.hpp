#pragma once
// The sessions of the page in a file that only its owner may read, so that they outlive a restart
// of the server: one a line, "<id> <last request, ms since 1970> <person>".
//
// A clock that was set back in between makes a session look used just now, never older.
// Threads: any. Pure but for Read and Write.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/view/http/login.hpp"

namespace musher::http {

std::string SessionsText(const std::vector<KeptSession>& sessions, std::int64_t wall_ms);
// Lines of another form are left out.
std::vector<KeptSession> SessionsIn(std::string_view text, std::int64_t wall_ms);

// None if there is no file; fails as ReadSecretFile() does.
Result<std::vector<KeptSession>> ReadSessions(const std::string& path, std::int64_t wall_ms);
Result<> WriteSessions(const std::string& path, const std::vector<KeptSession>& sessions,
                       std::int64_t wall_ms);

}  // namespace musher::http
