#include "musher/modules/device/can_socket.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace musher::device {
namespace {

// Of one turn of the loop, so that a flood leaves time for everything else.
constexpr int kMostInATurn = 64;

Error NetError(const std::string& message) {
  return {static_cast<std::int32_t>(KeyCode::kNetError), message};
}

std::string WhyLost(int error, const std::string& name) {
  if (error != ENETDOWN) return name + ": " + std::strerror(error);
  return name + " is down; type: sudo ip link set " + name +
         " up type can bitrate 1000000 restart-ms 100 (the bit rate of its devices)";
}

can_frame ToKernel(const CanFrame& frame) {
  can_frame raw{};
  raw.can_id = frame.id.number | (frame.id.extended ? CAN_EFF_FLAG : 0U);
  raw.can_dlc = frame.size;
  std::ranges::copy(frame.data, std::begin(raw.data));
  return raw;
}

CanFrame FromKernel(const can_frame& raw) {
  CanFrame frame;
  frame.id.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.id.number = raw.can_id & (frame.id.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.size = std::min<std::uint8_t>(raw.can_dlc, kCanBytes);
  std::ranges::copy(raw.data, frame.data.begin());
  return frame;
}

// Why the bus carries no frames, of an error frame of the kernel; empty: it does.
std::string BusFault(const can_frame& raw, const std::string& name) {
  if ((raw.can_id & CAN_ERR_BUSOFF) != 0) {
    return name +
           " is off after too many errors: look at cable, terminating resistors and bit rate; "
           "without restart-ms it stays off until you type: sudo ip link set " +
           name + " type can restart";
  }
  const bool passive = (raw.can_id & CAN_ERR_CRTL) != 0 &&
                       (raw.data[1] & (CAN_ERR_CRTL_TX_PASSIVE | CAN_ERR_CRTL_RX_PASSIVE)) != 0;
  if (passive) {
    return name + ": no other device takes its frames: look at their power, cable and bit rate";
  }
  return "";
}

bool IsRecovered(const can_frame& raw) {
  // CAN_ERR_CRTL_ACTIVE of newer kernels; a controller that is no longer passive warns at first.
  constexpr std::uint8_t kNotPassive = 0x40 | CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_RX_WARNING;
  return (raw.can_id & CAN_ERR_RESTARTED) != 0 ||
         ((raw.can_id & CAN_ERR_CRTL) != 0 && (raw.data[1] & kNotPassive) != 0);
}

}  // namespace

Result<std::unique_ptr<CanBus>> CanSocket::Open(transport::EventLoop& loop,
                                                const std::string& network_interface,
                                                Events events) {
  const auto failed = [&](const std::string& what) {
    return NetError(network_interface + ": " + what + ": " + std::strerror(errno));
  };
  UniqueFd fd(socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!fd.valid()) return failed("this system has no SocketCAN");
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(network_interface.c_str()));
  if (address.can_ifindex == 0) {
    return NetError("this computer has no network interface '" + network_interface +
                    "'; `ip -brief link` lists them");
  }
  const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_CRTL | CAN_ERR_RESTARTED;
  if (setsockopt(fd.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0) {
    return failed("its errors cannot be received");
  }
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return failed("it cannot be received from");
  }
  int down = 0;
  socklen_t size = sizeof down;
  if (getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &down, &size) == 0 && down != 0) {
    return NetError(WhyLost(down, network_interface));
  }
  return std::unique_ptr<CanBus>(
      std::make_unique<CanSocket>(loop, network_interface, std::move(fd), std::move(events)));
}

CanSocket::CanSocket(transport::EventLoop& loop, std::string network_interface, UniqueFd fd,
                     Events events)
    : name_(std::move(network_interface)),
      events_(std::move(events)),
      fd_(std::move(fd)),
      readable_(loop.WhenReadable(fd_.get(), [this] { Receive(); })) {}

Result<> CanSocket::Send(const CanFrame& frame) {
  const can_frame raw = ToKernel(frame);
  const ssize_t sent = send(fd_.get(), &raw, sizeof raw, 0);
  if (sent == static_cast<ssize_t>(sizeof raw)) return Ok();
  if (errno == ENOBUFS || errno == EAGAIN) {
    return NetError(name_ + ": its queue is full: no other device takes its frames");
  }
  return NetError(name_ + ": " + std::strerror(errno));
}

void CanSocket::Filter(const std::vector<CanId>& ids) {
  std::vector<can_filter> filters;
  filters.reserve(ids.size() + 1);
  for (const CanId& id : ids) {
    filters.push_back({id.number | (id.extended ? CAN_EFF_FLAG : 0U), CAN_EFF_FLAG | CAN_EFF_MASK});
  }
  if (filters.empty()) filters.push_back({0, 0});
  // Without a filter more is received than is used.
  static_cast<void>(setsockopt(fd_.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                               static_cast<socklen_t>(filters.size() * sizeof(can_filter))));
}

void CanSocket::Receive() {
  for (int i = 0; i < kMostInATurn; ++i) {
    can_frame raw{};
    const ssize_t size = recv(fd_.get(), &raw, sizeof raw, 0);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size <= 0) return Lose(size == 0 ? ENODEV : errno);
    if (size != static_cast<ssize_t>(sizeof raw)) continue;  // not a frame of CAN 2.0
    if ((raw.can_id & CAN_ERR_FLAG) == 0) {
      events_.on_frame(FromKernel(raw));
    } else if (const std::string fault = BusFault(raw, name_); !fault.empty()) {
      events_.on_fault(fault);
    } else if (IsRecovered(raw)) {
      events_.on_recovered();
    }
  }
}

void CanSocket::Lose(int error) {
  readable_.reset();
  events_.on_lost(WhyLost(error, name_));
}

}  // namespace musher::device
