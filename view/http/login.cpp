#include "musher/view/http/login.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>

#include "musher/base/check.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"

namespace musher::http {
namespace {

constexpr std::size_t kSecretBytes = 16;
constexpr std::size_t kMaxName = 64;  // bytes
constexpr std::size_t kPinDigits = 6;
constexpr std::size_t kMaxSecretFile = 65536;  // bytes

Error LoginError(std::string message) {
  return {kCodePermissionDenied, std::move(message)};
}

std::string RandomHex(const Random& random) {
  std::array<std::byte, kSecretBytes> bytes{};
  random(bytes);
  std::string text;
  for (const std::byte byte : bytes) {
    static constexpr std::string_view kDigits = "0123456789abcdef";
    text += kDigits[static_cast<unsigned>(byte) >> 4];
    text += kDigits[static_cast<unsigned>(byte) & 0xF];
  }
  return text;
}

// One line of a log, whatever the program has sent.
std::string PlainName(const std::string& name) {
  std::string plain = name.substr(0, kMaxName);
  std::replace_if(
      plain.begin(), plain.end(), [](unsigned char c) { return c < 0x20 || c > 0x7e; }, '?');
  return plain;
}

bool IsTokenText(std::string_view text) {
  return text.size() == 2 * kSecretBytes && text.find_first_not_of("0123456789abcdef") == text.npos;
}

// Fails with EEXIST if the file exists.
Result<> MakeTokenFile(const std::string& path, const std::string& token) {
  const UniqueFd file(
      open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file.valid() || !WriteAll(file.get(), token + "\n")) return SystemError(path);
  return Ok();
}

}  // namespace

void KernelRandom(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t size = getrandom(bytes.data(), bytes.size(), 0);
    MUSHER_CHECK(size > 0 || errno == EINTR, "the kernel gives no random numbers");
    if (size > 0) bytes = bytes.subspan(static_cast<std::size_t>(size));
  }
}

bool SameSecret(std::string_view one, std::string_view other) {
  if (one.size() != other.size()) return false;  // the length is no secret
  unsigned char difference = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    const auto a = static_cast<unsigned char>(one[i]);
    const auto b = static_cast<unsigned char>(other[i]);
    difference = static_cast<unsigned char>(difference | (a ^ b));
  }
  const volatile unsigned char result = difference;
  return result == 0;
}

Login::Login(Random random, std::string token)
    : random_(std::move(random)), token_(std::move(token)) {}

std::string Login::NewSecret() {
  return RandomHex(random_);
}

Result<> Login::CheckFailures(const std::string& peer, Time now) {
  const auto found = failures_.find(peer);
  if (found == failures_.end()) return Ok();
  if (now - found->second.since >= kFailureTime) {
    failures_.erase(found);
    return Ok();
  }
  if (found->second.count < kMaxFailures) return Ok();
  return Error{kCodeTargetBusy, "too many wrong codes from " + peer + "; wait a minute"};
}

void Login::CountFailure(const std::string& peer, Time now) {
  if (failures_.size() >= kMaxAddresses && !failures_.contains(peer)) {
    failures_.erase(std::min_element(
        failures_.begin(), failures_.end(),
        [](const auto& one, const auto& other) { return one.second.since < other.second.since; }));
  }
  Failures& failures = failures_.try_emplace(peer, Failures{0, now}).first->second;
  ++failures.count;
}

Result<> Login::MayMakeLinks(std::string_view token, const std::string& peer, Time now) {
  if (!token_.empty() && SameSecret(token, token_)) return Ok();
  if (auto allowed = CheckFailures(peer, now); !allowed) return allowed;
  CountFailure(peer, now);
  return LoginError("the token is wrong");
}

LoginCode Login::NewCode(const std::string& name, Time now) {
  std::erase_if(codes_, [&](const Code& code) { return code.until <= now; });
  if (codes_.size() >= kMaxCodes) codes_.erase(codes_.begin());
  codes_.push_back({NewSecret(), PlainName(name), now + kCodeTime, false});
  pin_ = Pin{NewPin(), codes_.back().code};
  return {pin_->code, pin_->pin};
}

std::string Login::NewPin() {
  std::uint64_t number = 0;
  random_(std::as_writable_bytes(std::span(&number, 1)));
  const std::string digits = std::to_string(number % 1'000'000);
  return std::string(kPinDigits - digits.size(), '0') + digits;
}

Result<std::string> Login::RedeemPin(std::string_view offered, const std::string& peer, Time now) {
  const auto allowed = CheckFailures(peer, now);
  if (!allowed) return allowed.error();
  std::string pin(offered);
  std::erase_if(pin, [](char c) { return c == ' ' || c == '-'; });
  if (pin_ && SameSecret(pin, pin_->pin)) {
    const std::string code = std::exchange(pin_, std::nullopt)->code;
    return Redeem(code, peer, now);
  }
  CountFailure(peer, now);
  if (!pin_) return LoginError("no PIN is valid now; 'musher view --link' prints a new one");
  if (++pin_->wrong < kMaxWrongPins) return LoginError("the PIN is wrong");
  pin_.reset();
  return LoginError("the PIN is wrong, and after " + std::to_string(kMaxWrongPins) +
                    " wrong ones it is not valid any more; 'musher view --link' prints a new one");
}

Result<std::string> Login::Redeem(std::string_view offered, const std::string& peer, Time now) {
  Code* found = nullptr;
  for (Code& code : codes_) {
    if (SameSecret(offered, code.code)) found = &code;
  }
  if (found == nullptr || found->used || found->until <= now) {
    if (const auto allowed = CheckFailures(peer, now); !allowed) return allowed.error();
    CountFailure(peer, now);
    if (found == nullptr)
      return LoginError("the link is not valid; 'musher view' prints a new one");
    if (found->used) return LoginError("the link was used already; 'musher view' prints a new one");
    return LoginError("the link is older than 10 minutes; 'musher view' prints a new one");
  }
  found->used = true;
  std::erase_if(sessions_,
                [&](const Session& session) { return now - session.last >= kSessionTime; });
  if (sessions_.size() >= kMaxSessions) {
    sessions_.erase(std::min_element(
        sessions_.begin(), sessions_.end(),
        [](const Session& one, const Session& other) { return one.last < other.last; }));
  }
  const std::string person = found->name.empty() ? peer : found->name + " (" + peer + ")";
  sessions_.push_back({NewSecret(), person, now});
  return sessions_.back().id;
}

std::optional<std::string> Login::Find(std::string_view id, Time now) {
  Session* found = nullptr;
  for (Session& session : sessions_) {
    if (SameSecret(id, session.id)) found = &session;
  }
  if (found == nullptr || now - found->last >= kSessionTime) return std::nullopt;
  found->last = std::max(found->last, now);
  return found->person;
}

bool Login::Lives(std::string_view id, Time now) const {
  return std::any_of(sessions_.begin(), sessions_.end(), [&](const Session& session) {
    return SameSecret(id, session.id) && now - session.last < kSessionTime;
  });
}

void Login::End(std::string_view id) {
  std::erase_if(sessions_, [&](const Session& session) { return SameSecret(id, session.id); });
}

void Login::EndAll() {
  sessions_.clear();
  codes_.clear();
  pin_.reset();
}

std::vector<KeptSession> Login::Kept(Time now) const {
  std::vector<KeptSession> kept;
  for (const Session& session : sessions_) {
    const Duration idle = now - session.last;
    if (idle < kSessionTime) kept.push_back({session.id, session.person, idle});
  }
  return kept;
}

void Login::Restore(const std::vector<KeptSession>& kept, Time now) {
  for (const KeptSession& one : kept) {
    if (one.idle >= kSessionTime || sessions_.size() >= kMaxSessions) continue;
    sessions_.push_back({one.id, one.person, now - std::max(one.idle, Duration{})});
  }
}

Result<std::string> ReadSecretFile(const std::string& path) {
  const UniqueFd file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (!file.valid() && errno == ENOENT) return std::string();
  if (!file.valid()) return SystemError(path);
  struct stat info {};
  if (fstat(file.get(), &info) != 0) return SystemError(path);
  if (!S_ISREG(info.st_mode)) return LoginError(path + " is not a regular file");
  if (info.st_uid != geteuid()) {
    return LoginError(path + " belongs to user " + std::to_string(info.st_uid) + ", not to user " +
                      std::to_string(geteuid()));
  }
  if ((info.st_mode & 077) != 0) {
    return LoginError(path +
                      " can be read or written by other users; remove it, and a new one is " +
                      "made, or run: chmod 600 " + path);
  }
  std::string text(kMaxSecretFile, '\0');
  const ssize_t size = read(file.get(), text.data(), text.size());
  if (size < 0) return SystemError(path);
  text.resize(static_cast<std::size_t>(size));
  return text;
}

Result<std::string> ReadOrMakeToken(const std::string& path, const Random& random) {
  const std::string made = RandomHex(random);
  const auto written = MakeTokenFile(path, made);
  if (written) return made;
  if (access(path.c_str(), F_OK) != 0) return written.error();

  auto read = ReadSecretFile(path);
  if (!read) return read.error();
  std::string text = std::move(read).value();
  if (text.ends_with('\n')) text.pop_back();
  if (!IsTokenText(text)) {
    return Error{kCodeParametersInvalid,
                 path +
                     " does not contain a token of 32 hexadecimal digits; remove it, and a new " +
                     "one is made"};
  }
  return text;
}

}  // namespace musher::http
