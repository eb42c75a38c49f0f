#pragma once
// Publishes what the cameras of a simulated body and of robots see, each at its rate of world time
// and only while it has a subscriber.
//
//   world/camera/front, left, right          sensor_msgs/Image, bgr8
//   world/camera/front/info, left/..., ...   sensor_msgs/CameraInfo, latched
//   R/camera/image, R/camera/info            the same of each robot R of the scene with a camera
//
// A picture that is due is drawn beside the loop from the present pose of the body, and published
// when it is done with that time as its stamp. A picture that is due while the camera's last one
// is not done is skipped; or time waits for it, if the scene says so. The surfaces are painted
// before the first picture, which takes some tenths of a second.
//
// Threads: the loop's. Drawing runs on the worker, one picture at a time.

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/actuator/worker.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/world/render/render.hpp"
#include "musher/modules/world/simulation/world.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::world {

class WorldCameras {
 public:
  struct Options {
    std::function<void(const std::string&)> log;
    Worker* worker = nullptr;  // draws; outlives the cameras
    // World time can advance.
    std::function<void()> on_free;
  };

  // The cameras of the scene, on topics that `endpoints` keeps. Fails when one cannot be opened.
  static Result<std::unique_ptr<WorldCameras>> Make(transport::Endpoints& endpoints,
                                                    const Scene& scene, Options options);
  ~WorldCameras();

  // After each step of the world.
  void OnStep(const World& world);

  // Whether world time waits for a picture.
  bool waits() const { return !waiting_.empty(); }

 private:
  // One camera on the network.
  struct Outlet {
    std::string name;  // "front", "jetbot_0"
    std::string frame;
    CameraSpec spec;
    std::function<View(const World&)> view;
    transport::Publisher<msg::Image>* images = nullptr;
    bool busy = false;  // a shot is queued or drawn
    bool skipped = false;
  };
  struct Shot {
    std::size_t camera = 0;
    Duration at{};
    View view;
  };
  struct Studio;

  WorldCameras(transport::Node& node, const Scene& scene, Options options);
  void Open(transport::Endpoints& endpoints, Outlet outlet, const std::string& images,
            const std::string& info);
  void Request(const Shot& shot);
  void Skip(std::size_t camera);
  void Draw();
  void Finish(const Shot& shot, Result<Image> image);

  transport::Node& node_;
  const Options options_;
  const CameraSet::Late late_;
  std::vector<Outlet> outlets_;
  std::shared_ptr<Studio> studio_;  // where pictures are drawn; null after a failure
  std::deque<Shot> queue_;
  std::deque<Shot> waiting_;  // for the last picture of their camera
  bool drawing_ = false;
  bool drew_ = false;                                           // the surfaces are painted
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for callbacks from other threads
};

}  // namespace musher::world
