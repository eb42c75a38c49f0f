// Three cameras of 640x480 in colour at 15 Hz into a file: how many pictures are lost, what the
// recorder costs, how large the file is.
//
//   benchmark_record [SECONDS [lz4|zstd|none...]]

#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/process.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/mcap/scan.hpp"

namespace musher::benchmark {
namespace {

constexpr Duration kPeriod = std::chrono::nanoseconds(1'000'000'000 / 15);
constexpr std::size_t kPictures = 16;  // different ones

// Smooth shades with the noise of a sensor, which hardly compress, as those of a camera.
msg::Bytes Picture(std::mt19937& random) {
  msg::Image image;
  image.width = 640;
  image.height = 480;
  image.encoding = "bgr8";
  image.step = 3 * image.width;
  image.data.resize(std::size_t{image.step} * image.height);
  const std::size_t shift = random() % 640;
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const std::size_t x = (i % image.step) / 3;
    const std::size_t y = i / image.step;
    image.data[i] = static_cast<std::uint8_t>((x + shift + y) / 6 + random() % 8);
  }
  return msg::Encode(image);
}

struct Cameras {
  std::vector<std::unique_ptr<transport::RawWriter>> writers;
  std::vector<msg::Bytes> pictures;
  std::uint64_t sent = 0;

  bool Matched() const {
    for (const auto& writer : writers) {
      if (writer->MatchedReaders() == 0) return false;
    }
    return true;
  }
  void Send() {
    for (const auto& writer : writers) {
      if (!writer->Write(pictures[sent % pictures.size()])) Fail("a picture cannot be sent");
      ++sent;
    }
  }
};

void Measure(transport::EventLoop& loop, Cameras& cameras, int seconds,
             const std::string& compression) {
  std::string folder = (std::filesystem::temp_directory_path() / "musher-record-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) Fail("no folder");
  const std::string file = folder + "/run.mcap";
  Child recorder({Program("musher-record"), "record", "-o", file, "--compression", compression});
  if (!loop.RunUntil([&] { return cameras.Matched(); }, loop.Now() + std::chrono::seconds(30))) {
    Fail("the recorder does not subscribe");
  }
  cameras.sent = 0;
  const Duration before = CostOf(recorder.pid()).cpu;
  const Time begin = loop.Now();
  const auto timer = loop.Every(kPeriod, [&] { cameras.Send(); });
  static_cast<void>(loop.RunUntil([] { return false; }, begin + std::chrono::seconds(seconds)));
  // What is still under way.
  const std::uint64_t sent = cameras.sent;
  const double cpu_s = ToSeconds(CostOf(recorder.pid()).cpu - before);
  const double took_s = ToSeconds(loop.Now() - begin);
  const double resident_mb = CostOf(recorder.pid()).resident_mb;
  kill(recorder.pid(), SIGINT);
  const int exit = recorder.Wait();
  const auto scan = mcap::Scan::Open(file);
  if (!scan || exit != 0) Fail("the recording failed");
  const auto got = scan.value()->messages().size();
  std::printf("| %s | %llu | %lld | %.1f | %.0f | %.1f |\n", compression.c_str(),
              static_cast<unsigned long long>(sent),
              static_cast<long long>(sent) - static_cast<long long>(got), 100 * cpu_s / took_s,
              resident_mb, static_cast<double>(scan.value()->file_bytes()) / 1e6 / took_s);
  std::fflush(stdout);
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
}

void Run(int seconds, const std::vector<std::string>& compressions) {
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  transport::LinuxEventLoop loop;
  const auto node = transport::MakeDdsNode(loop);
  if (!node) Fail(node.error().message);
  Cameras cameras;
  std::mt19937 random(1);
  while (cameras.pictures.size() < kPictures) cameras.pictures.push_back(Picture(random));
  for (const char* topic : {"rt/image_front", "rt/image_left", "rt/image_right"}) {
    auto writer = node.value()->MakeRawWriter(topic, std::string(msg::Image::kTypeName),
                                              transport::kDefaultQos, {});
    if (!writer) Fail(writer.error().message);
    cameras.writers.push_back(std::move(writer).value());
  }
  std::printf("| compression | pictures | lost | CPU %% | MB resident | MB/s of file |\n");
  std::printf("|---|---|---|---|---|---|\n");
  for (const std::string& compression : compressions) Measure(loop, cameras, seconds, compression);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 60;
  std::vector<std::string> compressions(argv + std::min(argc, 2), argv + argc);
  if (compressions.empty()) compressions = {"none", "lz4", "zstd"};
  musher::benchmark::Run(std::max(seconds, 1), compressions);
}
