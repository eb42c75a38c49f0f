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
constexpr char kFailed = 'e';  // there is none; this packet says why

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

// RLIMIT_FSIZE holds for files in memory, too; a controller ignores its signal.
Result<UniqueFd> WriteFile(const msg::Bytes& reply) {
  UniqueFd file(memfd_create("musher-reply", MFD_CLOEXEC));
  if (file.valid() && WriteAll(file.get(), reply)) return file;
  const int failed = errno;
  Error error = SystemError(
      "cannot write its reply of " + std::to_string(reply.size()) + " bytes to a file in memory",
      failed);
  if (failed == EFBIG) {
    error.message += "; raise its limit of the file size: prlimit --fsize=unlimited --pid " +
                     std::to_string(getpid()) + ", for a systemd unit LimitFSIZE=infinity";
  }
  return error;
}

// A long reply is a file in memory: nothing waits, however slow its reader is. A short one needs no
// file, whose size may be limited to 0.
void SendReply(int socket, const msg::Bytes& reply) {
  if (reply.size() <= kLongestPacket) return SendPacket(socket, kReply, reply, -1);
  const auto file = WriteFile(reply);
  if (file) return SendPacket(socket, kInFile, {}, file.value().get());
  SendPacket(socket, kFailed, std::as_bytes(std::span(file.error().message)), -1);
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

Result<msg::Bytes> ReadFile(const UniqueFd& file) {
  const char* const failed = "has sent a reply whose file cannot be read";
  struct stat status {};
  if (!file.valid()) return SystemError(failed, EMFILE);  // the kernel has dropped the descriptor
  if (fstat(file.get(), &status) != 0) return SystemError(failed);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size > kLongestReply) return SystemError(failed, EFBIG);
  msg::Bytes bytes(size);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t part =
        pread(file.get(), bytes.data() + done, size - done, static_cast<off_t>(done));
    if (part <= 0) return SystemError(failed, part < 0 ? errno : EIO);
    done += static_cast<std::size_t>(part);
  }
  return bytes;
}

// What the call ends with. An error's message begins with the predicate of the server.
Result<msg::Bytes> ReplyIn(const Received& received, bool taken) {
  if (received.mark == kReply) return received.bytes;
  if (received.mark == kInFile) return ReadFile(received.file);
  if (received.mark == kFailed) {
    const auto* text = reinterpret_cast<const char*>(received.bytes.data());
    return Error{kCodeFailed, std::string(text, received.bytes.size())};
  }
  if (taken) return Error{kCodeNetError, "has ended the call without a reply"};
  return Error{kCodeUnSupport, "has not taken the request"};
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

// Reads the request of a caller. A caller that no longer waits has closed its end.
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
  watch_ = nullptr;
  const OnReply done = std::exchange(on_reply_, {});
  if (!done) return;
  auto reply = ReplyIn(received, taken_);
  if (reply) return done(std::move(reply));
  const std::string server = "process " + std::to_string(server_);
  done(Error{reply.error().code, server + " " + reply.error().message});
}

}  // namespace musher::transport
