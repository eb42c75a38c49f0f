// Watches pictures of benchmark_picture_source, however they come to it:
//
//   benchmark_picture_sink FILE SECONDS TOPIC...
//
// Says a byte when every topic has come, then measures, and leaves in FILE "lost N", "cpu_ns N" and
// a line with the latency of each picture in nanoseconds.

#include <sys/resource.h>

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/test/benchmark/camera/picture.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::benchmark {
namespace {

struct Watch {
  std::unique_ptr<transport::Subscription> subscription;
  std::uint32_t last = 0;  // 0: none yet
};

int Main(const std::string& file, int seconds, const std::vector<std::string>& topics) {
  transport::LinuxEventLoop loop;
  auto node = transport::MakeDdsNode(loop);
  if (!node) Fail(node.error().message);
  std::vector<Watch> watches(topics.size());
  std::vector<Duration> latencies;
  std::uint64_t lost = 0;
  std::size_t begun = 0;
  bool measuring = false;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    auto subscription = transport::MakeSubscription<msg::Image>(
        *node.value(), topics[i],
        [&, i](const msg::Image& picture, const auto&) {
          const Duration age = Age(picture);
          const std::uint32_t number = ReadNumber(picture);
          if (watches[i].last == 0) ++begun;
          if (measuring) {
            lost += number - watches[i].last - 1;
            latencies.push_back(age);
          }
          watches[i].last = number;
        },
        transport::kSensorDataQos);
    if (!subscription) Fail(subscription.error().message);
    watches[i].subscription = std::move(subscription).value();
  }
  const bool all =
      loop.RunUntil([&] { return begun == topics.size(); }, loop.Now() + std::chrono::seconds(20));
  if (!all) Fail("not all pictures come");
  std::cout << '.' << std::flush;
  measuring = true;
  const Duration before = CostOf(getpid()).cpu;
  loop.RunUntil([] { return false; }, loop.Now() + std::chrono::seconds(seconds));
  std::ofstream out(file);
  out << "lost " << lost << "\ncpu_ns " << (CostOf(getpid()).cpu - before).count() << '\n';
  for (const Duration latency : latencies) out << latency.count() << '\n';
  return out.good() ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  if (argc < 4) return EXIT_FAILURE;
  musher::benchmark::DieWithParent();
  return musher::benchmark::Main(argv[1], std::atoi(argv[2]), {argv + 3, argv + argc});
}
