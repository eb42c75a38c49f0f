// Stands in for the cameras of a world:
//
//   benchmark_picture_source WIDTH HEIGHT HZ TOPIC...
//
// Publishes a picture on each topic HZ times a second, one camera after the other within a period,
// as cameras that are not synchronised do. Its stamp is the steady clock's time before it is
// encoded, and its first pixels hold its number, so that a reader sees what is missing.

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/test/benchmark/camera/picture.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::benchmark {
namespace {

struct Camera {
  std::unique_ptr<transport::Publisher<msg::Image>> publisher;
  msg::Image picture;
  std::uint32_t number = 0;
  transport::LoopHandlePtr first;
  transport::LoopHandlePtr timer;
};

void Shoot(Camera& camera) {
  if (camera.publisher->MatchedReaders() == 0) return;
  camera.picture.header.stamp = StampNow();
  WriteNumber(camera.picture, ++camera.number);
  static_cast<void>(camera.publisher->Publish(camera.picture));
}

int Main(std::uint32_t width, std::uint32_t height, int hz,
         const std::vector<std::string>& topics) {
  transport::LinuxEventLoop loop;
  auto node = transport::MakeDdsNode(loop);
  if (!node) Fail(node.error().message);
  const Duration period(1'000'000'000 / hz);
  std::vector<Camera> cameras(topics.size());
  for (std::size_t i = 0; i < topics.size(); ++i) {
    Camera& camera = cameras[i];
    auto publisher =
        transport::MakePublisher<msg::Image>(*node.value(), topics[i], transport::kSensorDataQos);
    if (!publisher) Fail(publisher.error().message);
    camera.publisher = std::move(publisher).value();
    camera.picture = MakePicture(width, height);
    camera.first = loop.At(loop.Now() + period * i / topics.size(), [&camera, &loop, period] {
      camera.timer = loop.Every(period, [&camera] { Shoot(camera); });
    });
  }
  loop.Run();
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  if (argc < 5) return EXIT_FAILURE;
  musher::benchmark::DieWithParent();
  return musher::benchmark::Main(static_cast<std::uint32_t>(std::atoi(argv[1])),
                                 static_cast<std::uint32_t>(std::atoi(argv[2])), std::atoi(argv[3]),
                                 {argv + 4, argv + argc});
}
