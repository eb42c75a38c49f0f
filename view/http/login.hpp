#pragma once
// Who may act through the page: a link with a one-time code, or the PIN that is printed beside it,
// opens a session, which a cookie carries.
//
//   http::Login login(http::KernelRandom, token);
//   login.MayMakeLinks(offered, peer, now)   // `musher view` has read the token file
//   login.NewCode("anna", now)               // the link: http://robot:8765/login?code=..., a PIN
//   login.Redeem(code, peer, now)            // the value of the cookie
//   login.RedeemPin("482 103", peer, now)    // the same
//   login.Find(cookie, now)                  // whose session it is
//
// A code is valid for 10 minutes and once. A session ends after 12 hours without a request; of more
// than 64 the one that is idle for the longest time ends. Codes, sessions and tokens are 128 random
// bits or more, and compared in constant time. An address with 10 wrong codes or tokens within a
// minute has to wait until that minute is over, but with a right code or token, which cannot be
// guessed: behind a proxy all may have one address, and each of them could keep the others out.
//
// A PIN has six digits, so only that of the newest code is valid, and after 5 wrong ones, of
// whatever addresses, it is not any more: guessing succeeds for one of 200,000 codes.
//
// Pure: time and random numbers are given; of steady time. One thread. Errors are sentences for the
// person with kCodePermissionDenied, or kCodeTargetBusy for an address that has to wait.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::http {

inline constexpr Duration kCodeTime = std::chrono::minutes(10);
inline constexpr Duration kSessionTime = std::chrono::hours(12);
inline constexpr Duration kFailureTime = std::chrono::minutes(1);
inline constexpr std::size_t kMaxCodes = 64;
inline constexpr std::size_t kMaxSessions = 64;
inline constexpr std::size_t kMaxFailures = 10;  // of an address within kFailureTime
inline constexpr std::size_t kMaxAddresses = 1024;
inline constexpr std::size_t kMaxWrongPins = 5;  // of all addresses

// Fills `bytes` with random numbers that cannot be predicted.
using Random = std::function<void(std::span<std::byte> bytes)>;
void KernelRandom(std::span<std::byte> bytes);

// Whether both are the same; the time that it takes does not depend on where they differ.
bool SameSecret(std::string_view one, std::string_view other);

struct LoginCode {
  std::string code;
  std::string pin;  // "482103"
};

// What `musher view` prints for a person.
struct LoginLink {
  std::string path;  // "/login?code=..."
  std::string pin;
  std::string outside;  // "http://192.168.1.7:8765", for other hosts; empty: they cannot connect
};

// A session as it is kept over a restart of the server, see session_file.hpp.
struct KeptSession {
  std::string id;
  std::string person;
  Duration idle;  // since its last request

  friend bool operator==(const KeptSession&, const KeptSession&) = default;
};

class Login {
 public:
  // `token`: of ReadOrMakeToken(); empty: no token is valid.
  Login(Random random, std::string token);

  // Whether a program has the token. A wrong one counts as a failure of its address.
  Result<> MayMakeLinks(std::string_view token, const std::string& peer, Time now);

  // A code for a link. `name`: of the person it is for, as the requesting program names that
  // person.
  LoginCode NewCode(const std::string& name, Time now);
  // Begins a session; the value of its cookie.
  Result<std::string> Redeem(std::string_view code, const std::string& peer, Time now);
  // Spaces and hyphens in it do not count.
  Result<std::string> RedeemPin(std::string_view pin, const std::string& peer, Time now);

  // "anna (192.168.1.7)", and the session's 12 hours begin again; nullopt: it is not one, or over.
  std::optional<std::string> Find(std::string_view session, Time now);
  bool Lives(std::string_view session, Time now) const;  // its 12 hours do not begin again
  void End(std::string_view session);
  // All sessions, and the codes that were not used.
  void EndAll();

  std::vector<KeptSession> Kept(Time now) const;
  void Restore(const std::vector<KeptSession>& kept, Time now);

  std::size_t sessions() const { return sessions_.size(); }
  std::size_t codes() const { return codes_.size(); }

 private:
  struct Code {
    std::string code;
    std::string name;
    Time until;
    bool used = false;
  };
  struct Session {
    std::string id;
    std::string person;
    Time last;
  };
  struct Failures {
    std::size_t count = 0;
    Time since;
  };

  struct Pin {
    std::string pin;
    std::string code;
    std::size_t wrong = 0;
  };

  std::string NewSecret();
  std::string NewPin();
  Result<> CheckFailures(const std::string& peer, Time now);
  void CountFailure(const std::string& peer, Time now);

  const Random random_;
  const std::string token_;
  std::vector<Code> codes_;
  std::optional<Pin> pin_;  // of the newest code
  std::vector<Session> sessions_;
  std::map<std::string, Failures> failures_;  // by address
};

// What a file contains that only its owner may read; "" if there is none. Fails if others may read
// it, if another user owns it, or if it is not a regular file.
Result<std::string> ReadSecretFile(const std::string& path);

// The token in a file: its 32 characters of hexadecimal digits. Makes the file, which only its
// owner may read, if there is none; fails as ReadSecretFile() does, or without such a token in it.
Result<std::string> ReadOrMakeToken(const std::string& path, const Random& random);

}  // namespace musher::http
