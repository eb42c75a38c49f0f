#include "musher/view/http/session_file.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "musher/base/files.hpp"

namespace musher::http {
namespace {

constexpr std::size_t kIdLength = 32;

}  // namespace

std::string SessionsText(const std::vector<KeptSession>& sessions, std::int64_t wall_ms) {
  std::string text;
  for (const KeptSession& session : sessions) {
    text += session.id + " " + std::to_string(wall_ms - ToMilliseconds(session.idle)) + " " +
            session.person + "\n";
  }
  return text;
}

std::vector<KeptSession> SessionsIn(std::string_view text, std::int64_t wall_ms) {
  std::vector<KeptSession> sessions;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.find(' ', kIdLength + 1);
    const bool has_id = line.find_first_not_of("0123456789abcdef") == kIdLength &&
                        line[kIdLength] == ' ' && space != std::string::npos;
    if (!has_id) continue;
    std::int64_t last_ms = 0;
    const char* end = line.data() + space;
    const auto read = std::from_chars(line.data() + kIdLength + 1, end, last_ms);
    if (read.ec != std::errc() || read.ptr != end || last_ms < 0) continue;
    const std::int64_t idle_ms = std::max<std::int64_t>(0, wall_ms - last_ms);
    if (idle_ms >= ToMilliseconds(kSessionTime)) continue;
    sessions.push_back({line.substr(0, kIdLength), line.substr(space + 1), Milliseconds(idle_ms)});
  }
  return sessions;
}

Result<std::vector<KeptSession>> ReadSessions(const std::string& path, std::int64_t wall_ms) {
  const auto text = ReadSecretFile(path);
  if (!text) return text.error();
  return SessionsIn(text.value(), wall_ms);
}

Result<> WriteSessions(const std::string& path, const std::vector<KeptSession>& sessions,
                       std::int64_t wall_ms) {
  return ReplaceFile(path, SessionsText(sessions, wall_ms), {.mode = 0600});
}

}  // namespace musher::http
