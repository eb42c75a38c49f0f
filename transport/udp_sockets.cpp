#include "musher/transport/udp_sockets.hpp"

#include <arpa/inet.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace musher::transport {

namespace {

namespace fs = std::filesystem;

constexpr const char* kAny = "0.0.0.0";

struct Entry {
  UdpSocket socket;
  uid_t user = 0;
};
using Table = std::map<std::string, Entry>;  // by inode

bool IsLoopback(const std::string& address) {
  return address.starts_with("127.");
}

std::string AddressText(const std::string& hex) {
  in_addr address{};
  address.s_addr = static_cast<in_addr_t>(std::strtoul(hex.c_str(), nullptr, 16));
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

// "  sl  local_address rem_address   st tx_queue:rx_queue tr:when retrnsmt uid timeout inode …"
Table ReadTable(const std::string& path) {
  Table table;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);  // the names of the columns
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string skipped;
    std::string local;
    std::string remote;
    std::string inode;
    Entry entry;
    words >> skipped >> local >> remote >> skipped >> skipped >> skipped >> skipped >> entry.user >>
        skipped >> inode;
    const std::size_t colon = local.find(':');
    if (!words || colon == std::string::npos) continue;
    entry.socket.address = AddressText(local.substr(0, colon));
    entry.socket.port =
        static_cast<std::uint16_t>(std::strtoul(local.c_str() + colon + 1, nullptr, 16));
    entry.socket.connected = remote != "00000000:0000";
    table.emplace(inode, std::move(entry));
  }
  return table;
}

// nullopt: not visible.
std::optional<std::set<std::string>> SocketsOf(const fs::path& process) {
  std::set<std::string> inodes;
  std::error_code error;
  for (fs::directory_iterator fd(process / "fd", error), end; fd != end; fd.increment(error)) {
    std::error_code closed;
    const std::string target = fs::read_symlink(fd->path(), closed).string();
    constexpr std::string_view kSocket = "socket:[";
    if (!target.starts_with(kSocket)) continue;
    inodes.insert(target.substr(kSocket.size(), target.size() - kSocket.size() - 1));
  }
  if (error) return std::nullopt;
  return inodes;
}

bool IsElsewhere(const UdpSocket& socket, const std::vector<std::string>& own) {
  return !socket.connected && socket.address != kAny && !IsLoopback(socket.address) &&
         std::ranges::count(own, socket.address) == 0;
}

}  // namespace

std::vector<UdpProcess> ReadProcessesBoundElsewhere(const std::vector<std::string>& own) {
  Table table = ReadTable("/proc/net/udp");
  const auto elsewhere = [&own](const auto& one) { return IsElsewhere(one.second.socket, own); };
  std::vector<UdpProcess> found;
  if (std::ranges::none_of(table, elsewhere)) return found;
  std::error_code error;
  for (fs::directory_iterator process("/proc", error), end; process != end;
       process.increment(error)) {
    const pid_t pid = std::atoi(process->path().filename().c_str());
    const auto inodes = pid != 0 ? SocketsOf(process->path()) : std::nullopt;
    if (!inodes) continue;
    UdpProcess read{pid, 0, {}};
    for (const std::string& inode : *inodes) {
      const auto entry = table.find(inode);
      if (entry == table.end()) continue;
      read.user = entry->second.user;
      read.sockets.push_back(entry->second.socket);
      table.erase(entry);
    }
    if (!read.sockets.empty()) found.push_back(std::move(read));
  }
  std::map<uid_t, UdpProcess> hidden;
  for (const auto& [inode, entry] : table) {
    UdpProcess& all = hidden[entry.user];
    all.user = entry.user;
    all.sockets.push_back(entry.socket);
  }
  for (auto& [user, all] : hidden) found.push_back(std::move(all));
  std::erase_if(found, [&own](const UdpProcess& process) {
    return std::ranges::none_of(process.sockets,
                                [&own](const UdpSocket& one) { return IsElsewhere(one, own); });
  });
  return found;
}

std::optional<std::vector<std::string>> BoundAddresses(pid_t pid) {
  const fs::path process = "/proc/" + std::to_string(pid);
  const auto inodes = SocketsOf(process);
  if (!inodes) return std::nullopt;
  std::set<std::string> bound;
  for (const auto& [inode, entry] : ReadTable(process / "net/udp")) {
    if (inodes->contains(inode) && entry.socket.address != kAny) bound.insert(entry.socket.address);
  }
  return std::vector<std::string>(bound.begin(), bound.end());
}

bool ShareUdpPort(pid_t one, pid_t other) {
  const auto ports = [table = ReadTable("/proc/self/net/udp")](pid_t pid) {
    std::set<std::uint16_t> bound;
    const auto inodes = SocketsOf("/proc/" + std::to_string(pid));
    for (const std::string& inode : inodes.value_or(std::set<std::string>())) {
      const auto entry = table.find(inode);
      if (entry != table.end() && !entry->second.socket.connected)
        bound.insert(entry->second.socket.port);
    }
    return bound;
  };
  const std::set<std::uint16_t> ours = ports(other);
  return std::ranges::any_of(ports(one), [&](std::uint16_t port) { return ours.contains(port); });
}

std::optional<OtherAddress> FindOtherAddress(const std::vector<UdpProcess>& processes,
                                             int domain_id, const std::vector<std::string>& own) {
  const int discovery = 7400 + 250 * domain_id;  // the port of every process of the domain
  for (const UdpProcess& process : processes) {
    const auto& sockets = process.sockets;
    const bool in_domain = std::ranges::count(sockets, discovery, &UdpSocket::port) != 0;
    const bool shared = std::ranges::any_of(sockets, [&own](const UdpSocket& one) {
      return std::ranges::count(own, one.address) != 0;
    });
    const auto other = std::ranges::find_if(
        sockets, [&own](const UdpSocket& one) { return IsElsewhere(one, own); });
    if (in_domain && !shared && other != sockets.end()) {
      return OtherAddress{process.pid, other->address};
    }
  }
  return std::nullopt;
}

}  // namespace musher::transport
