#include "musher/cli/start/notifier.hpp"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <string_view>

namespace musher::cli {
namespace {

constexpr Duration kRetry = Milliseconds(100);

std::string_view KindOf(std::string_view message) {
  return message.substr(0, message.find('='));
}

}  // namespace

ServiceNotifier::ServiceNotifier(transport::EventLoop& loop) : loop_(loop) {
  const char* name = std::getenv("NOTIFY_SOCKET");  // NOLINT(concurrency-mt-unsafe)
  if (name == nullptr) return;
  const std::string_view path = name;
  if (!path.starts_with('/') && !path.starts_with('@')) return;
  if (path.size() >= sizeof(address_.sun_path)) return;
  address_.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), std::begin(address_.sun_path));
  if (path.starts_with('@')) address_.sun_path[0] = '\0';
  address_size_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  socket_ = UniqueFd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

ServiceNotifier::~ServiceNotifier() {
  SendQueued();
}

void ServiceNotifier::Notify(const std::string& message) {
  if (!enabled()) return;
  std::erase_if(queued_, [&](const std::string& old) { return KindOf(old) == KindOf(message); });
  queued_.push_back(message);
  SendQueued();
}

void ServiceNotifier::Ping() {
  if (!enabled()) return;
  SendQueued();
  if (queued_.empty()) Send("WATCHDOG=1");
}

// False if there was no room. Without a receiver the message is lost.
bool ServiceNotifier::Send(const std::string& message) {
  const auto* const to = reinterpret_cast<const sockaddr*>(&address_);
  if (sendto(socket_.get(), message.data(), message.size(), MSG_NOSIGNAL, to, address_size_) >= 0) {
    return true;
  }
  return errno != EAGAIN && errno != ENOBUFS && errno != EINTR;
}

void ServiceNotifier::SendQueued() {
  const auto left = std::find_if(queued_.begin(), queued_.end(),
                                 [this](const std::string& message) { return !Send(message); });
  queued_.erase(queued_.begin(), left);
  retry_ = nullptr;
  if (!queued_.empty()) retry_ = loop_.At(loop_.Now() + kRetry, [this] { SendQueued(); });
}

}  // namespace musher::cli
