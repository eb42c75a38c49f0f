// What the page costs the robot: CPU and memory of musher-view with 0, 1 and 50 pages open, and how
// long a switch of the machine takes beside them. The pages are WebSockets that read all they get;
// turns alternate, so that a busy computer slows all of them alike.
//
//   benchmark_view [TURNS [SWITCHES]]

#include <atomic>
#include <cstdlib>
#include <list>
#include <map>
#include <memory>
#include <thread>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/port.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/view/http/websocket_client.hpp"

namespace musher::benchmark {
namespace {

constexpr int kActuators = 10;

// Open pages, which a thread reads.
class Pages {
 public:
  Pages(std::uint16_t port, int count) {
    for (int i = 0; i < count; ++i) {
      clients_.emplace_back(port, "/live", "Sec-WebSocket-Protocol: musher.view.v1\r\n");
      if (!clients_.back().open()) Fail("musher-view refuses a page");
      polls_.push_back({clients_.back().fd(), POLLIN, 0});
    }
    reader_ = std::thread([this] { Read(); });
  }
  ~Pages() {
    stop_ = true;
    reader_.join();
  }
  Pages(const Pages&) = delete;
  Pages& operator=(const Pages&) = delete;

  std::size_t bytes() const { return bytes_; }

 private:
  void Read() {
    std::vector<char> chunk(65536);
    while (!stop_) {
      if (poll(polls_.data(), polls_.size(), 50) <= 0) continue;
      for (pollfd& one : polls_) {
        if (one.revents == 0) continue;
        const ssize_t size = recv(one.fd, chunk.data(), chunk.size(), 0);
        if (size <= 0) one.fd = -1;  // poll() leaves it out
        bytes_ += static_cast<std::size_t>(std::max<ssize_t>(size, 0));
      }
    }
  }

  std::list<http::WebSocketClient> clients_;
  std::vector<pollfd> polls_;
  std::atomic<bool> stop_ = false;
  std::atomic<std::size_t> bytes_ = 0;
  std::thread reader_;
};

std::unique_ptr<Child> StartView(std::uint16_t port) {
  auto view = std::make_unique<Child>(
      std::vector<std::string>{Program("musher-view"), "--port", std::to_string(port)},
      Child::Environment{}, Child::Output::kPiped);
  view->AwaitOutput();
  return view;
}

struct Measured {
  std::vector<double> switch_ms;  // of each turn the median
  std::vector<double> cpu_idle;   // % of a core
  std::vector<double> cpu_switching;
  std::vector<double> resident_mb;
  std::vector<double> kb_s;  // of all pages
};

double SwitchTime(ObservedController& robot, int switches) {
  std::vector<double> times;
  for (int i = 0; i < switches; ++i) {
    const Time begin = std::chrono::steady_clock::now();
    MustBeDone(robot.Switch(State(i % 2 == 0 ? kDeActive : kActive)));
    times.push_back(Microseconds(std::chrono::steady_clock::now() - begin) / 1000);
  }
  return Median(times);
}

void Turn(ObservedController& robot, const Child* view, std::uint16_t port, int pages, int switches,
          Measured& measured) {
  const Pages open(port, pages);
  const auto cpu = [&] { return view == nullptr ? Duration{} : CostOf(view->pid()).cpu; };
  constexpr Duration kIdle = std::chrono::seconds(3);
  Duration before = cpu();
  std::this_thread::sleep_for(kIdle);  // what is measured is the time itself
  measured.cpu_idle.push_back(100 * ToSeconds(cpu() - before) / ToSeconds(kIdle));
  before = cpu();
  const std::size_t bytes = open.bytes();
  const Time begin = std::chrono::steady_clock::now();
  measured.switch_ms.push_back(SwitchTime(robot, switches));
  const double passed_s = ToSeconds(std::chrono::steady_clock::now() - begin);
  measured.cpu_switching.push_back(100 * ToSeconds(cpu() - before) / passed_s);
  measured.kb_s.push_back(static_cast<double>(open.bytes() - bytes) / 1000 / passed_s);
  if (view != nullptr) measured.resident_mb.push_back(CostOf(view->pid()).resident_mb);
}

int Main(int turns, int switches) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  const Fleet fleet(kActuators, true);
  ObservedController robot(fleet.config_file());
  robot.AwaitAllThere();
  SwitchTime(robot, 2);

  Measured without;
  std::map<int, Measured> with;
  for (int turn = 0; turn < turns; ++turn) {
    Turn(robot, nullptr, 0, 0, switches, without);
    const std::uint16_t port = FreePort();
    const auto view = StartView(port);
    for (const int pages : {0, 1, 50}) {
      Turn(robot, view.get(), port, pages, switches, with[pages]);
    }
  }

  const Table table("The page, beside a machine of " + std::to_string(kActuators) + " actuators");
  table.Row("a switch without musher-view", without.switch_ms, "ms");
  for (const auto& [pages, measured] : with) {
    const std::string what = std::to_string(pages) + (pages == 1 ? " page: " : " pages: ");
    table.Row(what + "a switch", measured.switch_ms, "ms");
    table.Row(what + "a switch by one without", Ratios(measured.switch_ms, without.switch_ms), "×");
    table.Row(what + "CPU at rest", measured.cpu_idle, "% of a core");
    table.Row(what + "CPU while the machine switches all the time", measured.cpu_switching,
              "% of a core");
    table.Row(what + "memory (RSS)", measured.resident_mb, "MB");
    table.Row(what + "sent while it switches", measured.kb_s, "kB/s");
  }
  return 0;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  return musher::benchmark::Main(argc > 1 ? std::atoi(argv[1]) : 5,
                                 argc > 2 ? std::atoi(argv[2]) : 100);
}
