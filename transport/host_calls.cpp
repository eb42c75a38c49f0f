#include "musher/transport/host_calls.hpp"

#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

#include "musher/base/code.hpp"
#include "musher/base/host.hpp"

namespace musher::transport {
namespace {

constexpr std::size_t kLongestPacket = 64 << 10;
constexpr std::size_t kLongestReply = 64 << 20;
constexpr std::size_t kMostConnections = 64;
constexpr int kBacklog = 64;

// The process on the other side, if it is of root or of our own user.
std::optional<pid_t> TrustedPeer(int socket) {
  ucred peer{};
  socklen_t size = sizeof(peer);
  if (getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return std::nullopt;
  if (peer.uid != 0 && peer.uid != geteuid()) return std::nullopt;
  return peer.pid;
}

bool WriteAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

constexpr char kTaken = 't';
constexpr char kReply = 'r';   // in this packet
constexpr char kInFile = 'f';  // in the file of the packet's descriptor

// Its failure closes the connection, as the caller notices.
void SendPacket(int socket, char mark, std::span<const std::byte> bytes, int file) {
  std::array<iovec, 2> parts{};
  parts[0] = {&mark, sizeof(mark)};
  parts[1] = {const_cast<std::byte*>(bytes.data()), bytes.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr header{};
  header.msg_iov = parts.data();
  header.msg_iovlen = parts.size();
  if (file >= 0) {
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    cmsghdr* rights = CMSG_FIRSTHDR(&header);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(rights), &file, sizeof(file));
  }
  static_cast<void>(sendmsg(socket, &header, MSG_DONTWAIT | MSG_NOSIGNAL));
}

// A long reply is a file in memory: nothing waits, however slow its reader is. A short one needs no
// file, whose size may be limited to 0 (RLIMIT_FSIZE).
void SendReply(int socket, const msg::Bytes& reply) {
  if (reply.size() <= kLongestPacket) return SendPacket(socket, kReply, reply, -1);
  const UniqueFd file(memfd_create("musher-reply", MFD_CLOEXEC));
  if (!file.valid() || !WriteAll(file.get(), reply)) return;
  SendPacket(socket, kInFile, {}, file.get());
}

// What the server has sent; mark 0: nothing more.
struct Received {
  char mark = 0;
  msg::Bytes bytes{};
  UniqueFd file{};
};

Received Receive(int socket) {
  Received received;
  received.bytes.resize(kLongestPacket);
  std::array<iovec, 2> parts{};
  parts[0] = {&received.mark, sizeof(received.mark)};
  parts[1] = {received.bytes.data(), received.bytes.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr header{};
  header.msg_iov = parts.data();
  header.msg_iovlen = parts.size();
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  const ssize_t size = recvmsg(socket, &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (size <= 0) return {};
  received.bytes.resize(static_cast<std::size_t>(size) - 1);
  const cmsghdr* rights = CMSG_FIRSTHDR(&header);
  if (rights != nullptr && rights->cmsg_type == SCM_RIGHTS) {
    int fd = -1;
    std::memcpy(&fd, CMSG_DATA(rights), sizeof(fd));
    received.file = UniqueFd(fd);
  }
  return received;
}

std::optional<msg::Bytes> ReadFile(const UniqueFd& file) {
  struct stat status {};
  if (!file.valid() || fstat(file.get(), &status) != 0) return std::nullopt;
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > kLongestReply) return std::nullopt;
  msg::Bytes bytes(size);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t part =
        pread(file.get(), bytes.data() + done, size - done, static_cast<off_t>(done));
    if (part <= 0) return std::nullopt;
    done += static_cast<std::size_t>(part);
  }
  return bytes;
}

}  // namespace

Result<std::unique_ptr<HostServer>> HostServer::Make(EventLoop& loop, std::string_view name) {
  auto socket = ListenAt(name, kBacklog);
  if (!socket) return socket.error();
  std::unique_ptr<HostServer> server(new HostServer(loop, std::move(socket).value()));
  server->watch_ =
      loop.WhenReadable(server->socket_.get(), [self = server.get()] { self->Accept(); });
  return server;
}

void HostServer::Accept() {
  UniqueFd socket(accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (!socket.valid()) return;
  if (connections_->size() >= kMostConnections) return;  // the caller goes by the network
  const int id = ++last_;
  Connection& connection = (*connections_)[id];
  connection.socket = std::move(socket);
  connection.watch = loop_.WhenReadable(connection.socket.get(), [this, id] { Read(id); });
}

// The request, or the end of a caller that waits no longer.
void HostServer::Read(int id) {
  const auto found = connections_->find(id);
  if (found == connections_->end()) return;
  msg::Bytes packet(kLongestPacket);
  const ssize_t size = recv(found->second.socket.get(), packet.data(), packet.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  packet.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  const auto end = std::find(packet.begin(), packet.end(), std::byte{0});
  const std::string service(reinterpret_cast<const char*>(packet.data()),
                            static_cast<std::size_t>(end - packet.begin()));
  const auto handler = handlers_.find(service);
  const std::weak_ptr<std::map<int, Connection>> weak = connections_;
  const Reply reply = [weak, id](const msg::Bytes& bytes) {
    const auto connections = weak.lock();
    if (!connections) return;
    const auto caller = connections->find(id);
    if (caller == connections->end()) return;
    SendReply(caller->second.socket.get(), bytes);
    connections->erase(caller);
  };
  if (end == packet.end() || handler == handlers_.end()) {
    connections_->erase(id);
    return;
  }
  SendPacket(found->second.socket.get(), kTaken, {}, -1);
  handler->second(std::span(packet).subspan(service.size() + 1), reply);
}

std::unique_ptr<HostCall> HostCall::Make(EventLoop& loop, std::string_view name,
                                         std::string_view service,
                                         std::span<const std::byte> request, OnReply on_reply) {
  UniqueFd socket = ConnectTo(name);
  if (!socket.valid()) return nullptr;
  const auto server = TrustedPeer(socket.get());
  if (!server) return nullptr;
  msg::Bytes packet;
  for (const char letter : service) packet.push_back(static_cast<std::byte>(letter));
  packet.push_back(std::byte{0});
  packet.insert(packet.end(), request.begin(), request.end());
  if (packet.size() > kLongestPacket ||
      send(socket.get(), packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
    return nullptr;
  }
  std::unique_ptr<HostCall> call(new HostCall(std::move(socket), *server, std::move(on_reply)));
  call->watch_ = loop.WhenReadable(call->socket_.get(), [self = call.get()] { self->Read(); });
  return call;
}

void HostCall::Read() {
  const Received received = Receive(socket_.get());
  taken_ |= received.mark != 0;
  if (received.mark == kTaken) return;
  std::optional<msg::Bytes> reply;
  if (received.mark == kReply) reply = received.bytes;
  if (received.mark == kInFile) reply = ReadFile(received.file);
  watch_ = nullptr;
  const OnReply done = std::exchange(on_reply_, {});
  if (!done) return;
  if (reply) return done(*reply);
  const std::string server = "process " + std::to_string(server_);
  done(taken_ ? Error{kCodeNetError, server + " has ended the call without a reply"}
              : Error{kCodeUnSupport, server + " has not taken the request"});
}

}  // namespace musher::transport
