#pragma once
// The cameras on a simulated network, in virtual time, with their peers on a node of its own: the
// world that has the pictures, the subscribers, and the clients of the service. Other sources than
// topics, and the folder, are fakes of the test.

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/modules/camera/cameras.hpp"
#include "musher/test/modules/module_on_network.hpp"

namespace musher::camera {

// A device whose pictures and failures the test makes.
struct FakeDevice {
  bool open = false;
  int opened = 0;
  SourceEvents events;
};

class FakeSource : public Source {
 public:
  explicit FakeSource(FakeDevice& device) : device_(device) { device_.open = true; }
  FakeSource(const FakeSource&) = delete;
  FakeSource& operator=(const FakeSource&) = delete;
  ~FakeSource() override { device_.open = false; }

 private:
  FakeDevice& device_;
};

// Keeps pictures in memory and replies at once, or with the error it is given.
class FakeStore : public Store {
 public:
  struct Content {
    std::map<std::string, msg::Image> pictures;
    std::vector<NewFile> files;  // what pictures were to be named
    std::map<std::string, std::vector<msg::Image>> videos;
    std::string recording;
    std::optional<Error> error;
  };
  explicit FakeStore(Content& content) : content_(content) {}

  void Save(msg::Image picture, const NewFile& file, Done<std::string> done) override {
    if (content_.error) return done(*content_.error);
    content_.pictures[file.name] = std::move(picture);
    content_.files.push_back(file);
    done("/saved/" + file.name);
  }
  void BeginVideo(msg::Image first, const NewFile& file, double /*rate_hz*/,
                  Done<std::string> done) override {
    if (content_.error) return done(*content_.error);
    content_.recording = file.name;
    content_.videos[file.name].push_back(std::move(first));
    done("/saved/" + file.name);
  }
  void AddFrame(msg::Image picture) override {
    content_.videos.at(content_.recording).push_back(std::move(picture));
  }
  void EndVideo(Done<std::string> done) override {
    if (content_.error) return done(*content_.error);
    done("/saved/" + std::exchange(content_.recording, ""));
  }
  void List(Done<std::vector<std::string>> done) override {
    std::vector<std::string> files;
    for (const auto& [file, picture] : content_.pictures) files.push_back(file);
    done(files);
  }
  void Delete(const std::string& file, Done<void> done) override {
    if (content_.pictures.erase(file) == 1) return done(Ok());
    done(Error{4410, "there is no file " + file});
  }

 private:
  Content& content_;
};

inline msg::Image Picture(std::uint32_t width = 64, std::uint32_t height = 48) {
  msg::Image picture;
  picture.width = width;
  picture.height = height;
  picture.encoding = "bgr8";
  picture.step = width * 3;
  picture.data.assign(std::size_t{picture.step} * height, 7);
  return picture;
}

class CamerasOnANetwork : public test::ModuleOnNetwork {
 protected:
  CamerasOnANetwork() {
    for (const std::string name : {"front", "left"}) {
      CameraConfig camera;
      camera.name = name;
      camera.topic = "image_" + name;
      camera.frame_id = "camera_" + name;
      camera.source = name == "front" ? SourceKind::kWorld : SourceKind::kDevice;
      camera.from = name == "front" ? "world/camera/front" : "0";
      config_.cameras.push_back(camera);
    }
    config_.service.camera = "front";
  }

  void Start(const State& state = "Active") {
    cameras_ = test::Must(Cameras::Make(Around(), config_, std::make_unique<FakeStore>(saved_)));
    cameras_->Enter(state);
    Run(Milliseconds(500));  // discovery
  }
  Dependencies Around() {
    return {
        *robot_,
        "dog1",
        [this] { return Stamp(); },
        [this](const LogLine& log) { log_.push_back(log); },
        [this] { return may_; },
        [this](const CameraConfig& camera, SourceEvents events) -> Result<std::unique_ptr<Source>> {
          if (camera.source == SourceKind::kWorld) {
            return OpenTopic(*robot_, "dog1/" + camera.from, std::move(events));
          }
          ++device_.opened;
          device_.events = std::move(events);
          return std::unique_ptr<Source>(new FakeSource(device_));
        }};
  }

  // The world's front camera: 20 pictures a second, while it has a subscriber.
  void MakeWorld() {
    shots_ = Publisher<msg::Image>("dog1/world/camera/front", transport::kSensorDataQos);
    ticker_ = desk_->loop().Every(Milliseconds(50), [this] {
      if (shots_->MatchedReaders() == 0) return;
      ++drawn_;
      msg::Image picture = shot_;
      picture.header.stamp = Stamp();
      static_cast<void>(shots_->Publish(picture));
    });
  }
  template <msg::Message M>
  std::unique_ptr<transport::Subscription> Listen(const std::string& topic,
                                                  std::vector<M>& received) {
    return ModuleOnNetwork::Listen(topic, received, transport::kSensorDataQos);
  }
  msg::CameraService::Response Call(const msg::CameraService::Request& request) {
    return ModuleOnNetwork::Call<msg::CameraService>("dog1/camera_service", request);
  }
  std::vector<std::string> Lines() const {
    std::vector<std::string> lines;
    for (const LogLine& log : log_) lines.push_back(std::to_string(log.code) + " " + log.text);
    return lines;
  }

  CamerasConfig config_;
  std::vector<LogLine> log_;
  Result<> may_;
  FakeDevice device_;
  FakeStore::Content saved_;
  msg::Image shot_ = Picture();
  int drawn_ = 0;
  std::unique_ptr<transport::Publisher<msg::Image>> shots_;
  transport::LoopHandlePtr ticker_;
  std::unique_ptr<Cameras> cameras_;
};

}  // namespace musher::camera
