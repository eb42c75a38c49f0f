#pragma once
// The parts of a request's head that name something, decoded and checked: the path cannot leave a
// folder, and all texts are valid UTF-8. Pure; threads: any. Errors carry kCodeParametersInvalid.

#include <map>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher::http {

inline constexpr std::size_t kMaxTarget = 4096;  // bytes, as sent
inline constexpr std::size_t kMaxParameters = 64;

struct Target {
  std::string path;                          // begins with '/'; "//" is one '/'
  std::map<std::string, std::string> query;  // the first of a name counts
};

// "/api/log?actuator=motion&from=-100". Refused: other forms, "." and ".." as a part of the path,
// '/' written as %2f, backslashes, control characters, bytes that are not UTF-8, incomplete
// escapes, more than kMaxTarget bytes or kMaxParameters parameters.
Result<Target> ParseTarget(std::string_view target);

// "a=1; b=2" of a Cookie header. What is not name=value is left out; the first of a name counts.
std::map<std::string, std::string> ParseCookies(std::string_view header);

// Whether it is UTF-8 as Unicode defines it: shortest form, no surrogates, up to U+10FFFF.
bool IsUtf8(std::string_view text);

// "Robot.Local:8765" as "robot.local" and "8765"; "[::1]:80" as "::1" and "80".
struct Authority {
  std::string host;  // lower case, without brackets
  std::string port;  // empty: not given
};
Result<Authority> ParseAuthority(std::string_view text);

std::string LowerCase(std::string_view text);  // of ASCII
// Without spaces and tabs at its ends.
std::string_view Trim(std::string_view text);

}  // namespace musher::http
