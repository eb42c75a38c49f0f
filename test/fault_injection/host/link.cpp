#include "musher/test/fault_injection/host/link.hpp"

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <system_error>

#include "musher/test/fault_injection/host/isolation.hpp"

namespace musher::fault_injection {
namespace {

constexpr std::size_t kLongestFrame = 2048;  // the interfaces' MTU is 1500
constexpr int kBatch = 64;                   // packets of one direction in a row

[[noreturn]] void Fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

// In the network namespace of the calling thread.
UniqueFd OpenEnd(const char* address) {
  UniqueFd fd(open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!fd.valid()) Fail("/dev/net/tun");
  ifreq request{};
  std::snprintf(request.ifr_name, sizeof(request.ifr_name), "%s", Link::kInterface);
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (ioctl(fd.get(), TUNSETIFF, &request) != 0) Fail("TUNSETIFF");
  SetAddress(Link::kInterface, address);
  BringUp(Link::kInterface);
  return fd;
}

}  // namespace

Link::Link(pid_t there) : there_(there), here_fd_(OpenEnd(kHere)) {
  InThere([this] { there_fd_ = OpenEnd(kThere); });
  wake_ = UniqueFd(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  thread_ = std::thread([this] { Run(); });
}

Link::~Link() {
  stop_ = true;
  eventfd_write(wake_.get(), 1);
  thread_.join();
}

// Runs `work` on a thread of its own, which enters the other namespace.
void Link::InThere(const std::function<void()>& work) const {
  std::exception_ptr error;
  std::thread([&] {
    try {
      const std::string path = "/proc/" + std::to_string(there_) + "/ns/net";
      const UniqueFd other(open(path.c_str(), O_RDONLY | O_CLOEXEC));
      if (!other.valid() || setns(other.get(), CLONE_NEWNET) != 0) Fail(path);
      work();
    } catch (...) {
      error = std::current_exception();
    }
  }).join();
  if (error) std::rethrow_exception(error);
}

void Link::Set(const LinkImpairment& to_there, const LinkImpairment& to_here, std::uint64_t seed) {
  const std::lock_guard lock(mutex_);
  to_there_ = to_there;
  to_here_ = to_here;
  random_ = Random(seed);
}

void Link::LinkDown(bool there) {
  if (!there) return TakeDown(kInterface);
  InThere([] { TakeDown(kInterface); });
}

void Link::LinkUp(bool there) {
  if (!there) return BringUp(kInterface);
  InThere([] { BringUp(kInterface); });
}

void Link::Run() {
  while (!stop_) {
    int wait_ms = -1;
    if (!under_way_.empty()) {
      const Duration rest = under_way_.begin()->first - std::chrono::steady_clock::now();
      wait_ms = static_cast<int>(std::max<std::int64_t>(0, ToMilliseconds(rest) + 1));
    }
    std::array<pollfd, 3> ready = {
        {{here_fd_.get(), POLLIN, 0}, {there_fd_.get(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
    poll(ready.data(), ready.size(), wait_ms);
    {
      const std::lock_guard lock(mutex_);
      Take(here_fd_.get(), there_fd_.get(), to_there_);
      Take(there_fd_.get(), here_fd_.get(), to_here_);
    }
    Deliver();
  }
}

void Link::Take(int from, int to, const LinkImpairment& impairment) {
  std::array<char, kLongestFrame> frame{};
  for (int i = 0; i < kBatch; ++i) {
    const ssize_t size = read(from, frame.data(), frame.size());
    if (size <= 0) return;
    const int copies = random_.Bernoulli(impairment.duplicate_percent) ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy) {
      if (random_.Bernoulli(impairment.loss_percent)) continue;
      const Duration more = impairment.jitter > Duration::zero()
                                ? Duration(random_.Between(0, impairment.jitter.count()))
                                : Duration::zero();
      const Time due = std::chrono::steady_clock::now() + impairment.delay + more;
      under_way_.emplace(due, Packet{to, {frame.data(), frame.data() + size}});
    }
  }
}

void Link::Deliver() {
  const Time now = std::chrono::steady_clock::now();
  while (!under_way_.empty() && under_way_.begin()->first <= now) {
    const Packet& packet = under_way_.begin()->second;
    // The write fails at an end that is down, as on an unplugged link.
    [[maybe_unused]] const ssize_t sent =
        write(packet.to, packet.bytes.data(), packet.bytes.size());
    under_way_.erase(under_way_.begin());
  }
}

}  // namespace musher::fault_injection
