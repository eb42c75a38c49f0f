#include "musher/modules/world/process/world_cameras.hpp"

#include <map>
#include <optional>
#include <utility>

#include "musher/modules/world/process/world_messages.hpp"
#include "musher/modules/world/render/scenery.hpp"
#include "musher/modules/world/render/shot.hpp"

namespace musher::world {

// Used by one picture at a time, wherever it is drawn.
struct WorldCameras::Studio {
  explicit Studio(const Scene& of) : scene(of) {}

  Result<Image> Draw(const Shot& shot, const CameraSpec& spec) {
    if (!scenery) {
      auto made = Scenery::Make(scene);
      if (!made) return made.error();
      scenery = std::move(made).value();
    }
    std::unique_ptr<Camera>& camera = cameras[shot.camera];
    if (!camera) camera = std::make_unique<Camera>(spec);
    return camera->Shoot(*scenery, shot.view);
  }

  const Scene scene;
  std::unique_ptr<Scenery> scenery;
  std::map<std::size_t, std::unique_ptr<Camera>> cameras;  // by outlet
};

WorldCameras::WorldCameras(transport::Node& node, const Scene& scene, Options options)
    : node_(node),
      options_(std::move(options)),
      late_(scene.cameras.late),
      studio_(std::make_shared<Studio>(scene)) {}

WorldCameras::~WorldCameras() = default;

Result<std::unique_ptr<WorldCameras>> WorldCameras::Make(transport::Endpoints& endpoints,
                                                         const Scene& scene, Options options) {
  std::unique_ptr<WorldCameras> cameras(
      new WorldCameras(endpoints.node(), scene, std::move(options)));
  for (std::size_t i = 0; scene.has_body && i < kCameras; ++i) {
    const CameraSpec& spec = scene.cameras.cameras[i];
    if (!spec.enabled) continue;
    const std::string name(kCameraNames[i]);
    const std::string topic = "world/camera/" + name;
    Outlet outlet;
    outlet.name = name;
    outlet.frame = "camera_" + name;
    outlet.spec = spec;
    outlet.view = [i](const World& world) { return ViewOf(world, i); };
    cameras->Open(endpoints, std::move(outlet), topic, topic + "/info");
  }
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const RobotSpec& robot = scene.robots[i];
    if (!robot.camera || !robot.camera->enabled) continue;
    Outlet outlet;
    outlet.name = robot.name;
    outlet.frame = robot.name + "/camera";
    outlet.spec = *robot.camera;
    outlet.view = [i](const World& world) { return ViewOfRobot(world, i); };
    cameras->Open(endpoints, std::move(outlet), robot.name + "/camera/image",
                  robot.name + "/camera/info");
  }
  if (!endpoints.opened()) return endpoints.opened().error();
  return cameras;
}

void WorldCameras::Open(transport::Endpoints& endpoints, Outlet outlet, const std::string& images,
                        const std::string& info) {
  outlet.images = endpoints.Advertise<msg::Image>(images, transport::kSensorDataQos);
  auto* calibration = endpoints.Advertise<msg::CameraInfo>(info, transport::kLatchedQos);
  if (!endpoints.opened()) return;
  if (auto sent = calibration->Publish(ToCameraInfo(IntrinsicsOf(outlet.spec), outlet.frame));
      !sent) {
    options_.log(info + " could not be published: " + sent.error().message);
  }
  outlets_.push_back(std::move(outlet));
}

void WorldCameras::OnStep(const World& world) {
  if (!studio_) return;
  for (std::size_t i = 0; i < outlets_.size(); ++i) {
    const Outlet& outlet = outlets_[i];
    if (!IsDue(world.now(), outlet.spec.rate_hz) || outlet.images->MatchedReaders() == 0) continue;
    if (world.IsSilent("camera " + outlet.name)) continue;
    Request({i, world.now(), outlet.view(world)});
  }
}

void WorldCameras::Request(const Shot& shot) {
  Outlet& outlet = outlets_[shot.camera];
  if (outlet.busy && late_ == CameraSet::Late::kSkip) return Skip(shot.camera);
  if (outlet.busy) {
    waiting_.push_back(shot);
    return;
  }
  outlet.busy = true;
  queue_.push_back(shot);
  Draw();
}

// Logged once; the first pictures are late because the surfaces are being painted.
void WorldCameras::Skip(std::size_t camera) {
  Outlet& outlet = outlets_[camera];
  if (!drew_ || outlet.skipped) return;
  outlet.skipped = true;
  options_.log("camera " + outlet.name +
               ": a shot was due while the last one was still being drawn, and is skipped; "
               "further ones are not logged");
}

void WorldCameras::Draw() {
  if (drawing_ || queue_.empty()) return;
  drawing_ = true;
  const Shot shot = queue_.front();
  queue_.pop_front();
  auto image = std::make_shared<std::optional<Image>>();
  const auto work = [studio = studio_, shot, spec = outlets_[shot.camera].spec,
                     image]() -> Result<> {
    auto drawn = studio->Draw(shot, spec);
    if (!drawn) return drawn.error();
    *image = std::move(drawn).value();
    return Ok();
  };
  const auto done = [this, alive = std::weak_ptr(alive_), loop = &node_.loop(), shot,
                     image](const Result<>& drawn) {
    loop->Post([this, alive, shot, image, drawn] {
      if (!alive.expired()) Finish(shot, drawn ? Result<Image>(std::move(**image)) : drawn.error());
    });
  };
  options_.worker->Run(work, done);
}

void WorldCameras::Finish(const Shot& shot, Result<Image> image) {
  Outlet& outlet = outlets_[shot.camera];
  drawing_ = false;
  drew_ = true;
  outlet.busy = false;
  const bool waited = waits();
  if (!image) {
    options_.log("the cameras are off: " + image.error().message);
    studio_.reset();
    queue_.clear();
    waiting_.clear();
  } else {
    // The next one follows soon.
    static_cast<void>(
        outlet.images->Publish(ToMessage(std::move(image).value(), outlet.frame, shot.at)));
  }
  for (auto it = waiting_.begin(); it != waiting_.end(); ++it) {
    if (it->camera != shot.camera) continue;
    const Shot next = *it;
    waiting_.erase(it);
    Request(next);
    break;
  }
  Draw();
  if (waited && !waits()) options_.on_free();
}

}  // namespace musher::world
