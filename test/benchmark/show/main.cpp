// From the camera to the state of the show: musher-vision-manager and musher-wedding as processes
// of a machine, and this program in the place of the camera. How long after the first picture with
// a guest in it, or after a word of perception, has /wedding/fsm/state changed?
//
//   benchmark_show [ROUNDS]

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"

namespace musher::benchmark {
namespace {

namespace fs = std::filesystem;

constexpr Duration kWaitLimit = std::chrono::seconds(30);
constexpr Duration kFrame = std::chrono::microseconds(33'333);  // 30 Hz
constexpr Duration kQuiet = Milliseconds(200);         // the last picture has been looked at
constexpr Duration kEmptyHall{};                       // of the scene: the hall is empty
constexpr Duration kGuest = std::chrono::seconds(10);  // and now one stands there

constexpr const char* kMachine = R"([controller]
actuators = ["vision", "wedding"]
states = ["SetUp", "SelfCheck", "Active", "TearDown"]
default_time = 10000
default_state = "Uninitialized"
name = "show"
[actuator.vision]
states = ["SetUp", "SelfCheck", "Active", "TearDown"]
times = [10000, 10000, 10000, 10000]
command = ["musher-vision-manager", "vision.toml"]
cwd = "."
critical = true
[actuator.wedding]
states = ["SetUp", "SelfCheck", "Active", "TearDown"]
times = [10000, 10000, 10000, 10000]
command = ["musher-wedding", "wedding.toml"]
cwd = "."
critical = true
)";
// A guest who leaves is forgotten at once, so that the next one may come.
constexpr const char* kVision = R"(rate_hz = 0
[target]
lost_ms = 50
[faces]
forget_ms = 100
)";
constexpr const char* kWedding = R"([check]
audio = "none"
motion = "none"
[perception]
age_ms = 100
[tracking]
lost_ms = 100
[farewell]
time_ms = 50
[safe_stop]
clear_ms = 50
)";

fs::path folder_of_show;

void TakeDown() {
  const fs::path folder = std::exchange(folder_of_show, {});
  if (folder.empty()) return;
  Child({Program("musher"), "down"}, {}, Child::Output::kNowhere).Wait();
  std::error_code none;
  fs::remove_all(folder, none);
}

template <class T>
T Must(Result<T> made) {
  if (!made) Fail(made.error().message);
  return std::move(made).value();
}

// What the front camera of the wedding hall sees at that time of its scene.
msg::Image PictureAt(Duration time, msg::CameraInfo& info) {
  world::SceneReading reading = world::ReadSceneFile(SourceDir() + "/config/scenes/wedding.toml");
  if (!reading.scene) Fail("the wedding's scene cannot be read");
  const world::CameraSpec camera = reading.scene->cameras.cameras[0];
  world::World world(std::move(*reading.scene));
  while (world.now() < time) world.Step();
  const world::Image shot = Must(world::TakeShot(world, 0));
  msg::Image picture;
  picture.width = static_cast<std::uint32_t>(camera.width_px);
  picture.height = static_cast<std::uint32_t>(camera.height_px);
  picture.encoding = "bgr8";
  picture.step = picture.width * 3;
  picture.data = shot.bgr;
  info.width = picture.width;
  info.height = picture.height;
  const double focal_px = camera.width_px / 2.0 / std::tan(camera.hfov_rad / 2);
  info.k = {focal_px, 0, camera.width_px / 2.0, 0, focal_px, camera.height_px / 2.0, 0, 0, 1};
  return picture;
}

// The two programs, with a camera in their domain.
class Show {
 public:
  Show() {
    empty_ = PictureAt(kEmptyHall, info_);
    guest_ = PictureAt(kGuest, info_);
    folder_of_show = fs::temp_directory_path() / ("musher-show-" + std::to_string(getpid()));
    std::atexit(TakeDown);
    fs::create_directories(folder_of_show);
    Write("machine.toml", kMachine);
    Write("vision.toml", kVision);
    Write("wedding.toml", kWedding);
    setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
    setenv("XDG_STATE_HOME", (folder_of_show / "state").c_str(), 1);
    const fs::path programs = fs::path(Program("x")).parent_path();
    setenv("PATH", (programs.string() + ":" + getenv("PATH")).c_str(), 1);
    Connect();
    StartCamera();
    up_ = std::make_unique<Child>(
        std::vector<std::string>{Program("musher"), "up",
                                 (folder_of_show / "machine.toml").string()},
        Child::Environment{}, Child::Output::kNowhere);
    AwaitState("IDLE");
  }
  ~Show() { TakeDown(); }
  Show(const Show&) = delete;
  Show& operator=(const Show&) = delete;

  // From the first picture with a guest in it.
  Duration ByPicture() {
    const Time begun = Begin([this] { guest_is_there_ = true; });
    AwaitState("TRACKING");
    const Duration took = changed_ - begun;
    guest_is_there_ = false;
    AwaitState("IDLE");
    return took;
  }
  // From the sample with a face.
  Duration ByTarget() {
    msg::PointStamped target;
    target.header.frame_id = "camera";
    target.point = {0.5, 0.5, 1.5};
    const Time begun = Begin([&] { Say(target_->Publish(target)); });
    AwaitState("TRACKING");
    const Duration took = changed_ - begun;
    AwaitState("IDLE");
    return took;
  }
  // From the sample that a guest is too close. Without pictures: vision would publish at once that
  // no guest is.
  Duration ByDanger() {
    frames_.reset();
    loop_.RunUntil([] { return false; }, loop_.Now() + kQuiet);
    const Time begun = Begin([&] { Say(too_close_->Publish({true})); });
    AwaitState("SAFE_STOP");
    const Duration took = changed_ - begun;
    Say(too_close_->Publish({false}));
    AwaitState("IDLE");
    StartCamera();
    return took;
  }

 private:
  static void Write(const std::string& name, const char* text) {
    std::ofstream(folder_of_show / name) << text;
  }
  static void Say(const Result<>& said) {
    if (!said) Fail(said.error().message);
  }

  void StartCamera() {
    frames_ = loop_.Every(kFrame, [this] { Shoot(); });
  }
  void Connect() {
    node_ = Must(transport::MakeDdsNode(loop_));
    images_ =
        Must(transport::MakePublisher<msg::Image>(*node_, "image_rgb", transport::kSensorDataQos));
    infos_ = Must(transport::MakePublisher<msg::CameraInfo>(*node_, "image_rgb/camera_info",
                                                            transport::kDefaultQos));
    target_ =
        Must(transport::MakePublisher<msg::PointStamped>(*node_, "wedding/perception/target"));
    too_close_ = Must(transport::MakePublisher<msg::Bool>(*node_, "wedding/perception/too_close"));
    state_ = Must(transport::MakeSubscription<msg::String>(
        *node_, "wedding/fsm/state", [this](const msg::String& state, const auto&) {
          if (state.data == shown_) return;
          shown_ = state.data;
          changed_ = loop_.Now();
        }));
  }
  void Shoot() {
    msg::Image& picture = guest_is_there_ ? guest_ : empty_;
    picture.header.stamp = msg::ToStamp(
        std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()));
    info_.header = picture.header;
    if (begins_) {
      begins_ = false;
      begun_ = std::chrono::steady_clock::now();
    }
    Say(infos_->Publish(info_));
    Say(images_->Publish(picture));
  }
  // Does it at some time between two pictures; gives the time of the next picture, or of the word.
  Time Begin(const std::function<void()>& what) {
    const Time when = loop_.Now() + Duration(std::rand() % kFrame.count());
    bool done = false;
    const auto timer = loop_.At(when, [&] {
      begun_ = std::chrono::steady_clock::now();
      what();
      begins_ = guest_is_there_;
      done = true;
    });
    Await([&] { return done && !begins_; }, "its own timer");
    return begun_;
  }
  void AwaitState(const std::string& state) {
    Await([&] { return shown_ == state; }, "the state " + state);
  }
  void Await(const std::function<bool()>& done, const std::string& what) {
    if (!loop_.RunUntil(done, loop_.Now() + kWaitLimit)) Fail("waited in vain for " + what);
  }

  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  msg::Image empty_;
  msg::Image guest_;
  msg::CameraInfo info_;
  bool guest_is_there_ = false;
  bool begins_ = false;  // the next picture is the first with the guest
  Time begun_{};
  std::string shown_;
  Time changed_{};
  std::unique_ptr<transport::Publisher<msg::Image>> images_;
  std::unique_ptr<transport::Publisher<msg::CameraInfo>> infos_;
  std::unique_ptr<transport::Publisher<msg::PointStamped>> target_;
  std::unique_ptr<transport::Publisher<msg::Bool>> too_close_;
  std::unique_ptr<transport::Subscription> state_;
  transport::LoopHandlePtr frames_;
  std::unique_ptr<Child> up_;
};

int Run(int rounds) {
  Show show;
  std::vector<double> by_picture;
  std::vector<double> by_target;
  std::vector<double> by_danger;
  for (int i = 0; i < rounds; ++i) {
    by_picture.push_back(Microseconds(show.ByPicture()) / 1000);
    by_target.push_back(Microseconds(show.ByTarget()) / 1000);
    by_danger.push_back(Microseconds(show.ByDanger()) / 1000);
  }
  const Table table("From perception to the state of the show (30 Hz camera, 50 Hz show)");
  table.Row("first of two pictures with a guest → TRACKING", by_picture, "ms");
  table.Row("target → TRACKING", by_target, "ms");
  table.Row("too_close → SAFE_STOP", by_danger, "ms");
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  return musher::benchmark::Run(argc > 1 ? std::atoi(argv[1]) : 50);
}
