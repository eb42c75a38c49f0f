#pragma once
// camera_service, and the topic `image` that it starts and stops.
//
// Threads: the loop's.

#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/camera/camera_device.hpp"
#include "musher/modules/camera/pace.hpp"
#include "musher/modules/camera/service_core.hpp"
#include "musher/modules/camera/store.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::camera {

class CameraServer {
 public:
  static constexpr Duration kPictureTime = Milliseconds(2000);  // timeout for the next picture
  static constexpr double kVideoHz = 15;  // if neither request nor camera gives a rate

  // Uses the pictures of `camera`, which outlives it.
  static Result<std::unique_ptr<CameraServer>> Make(const Dependencies& dependencies,
                                                    const ServiceConfig& config,
                                                    CameraDevice& camera,
                                                    std::unique_ptr<Store> store);
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;
  ~CameraServer();

  // The camera is off from now on: ends a recording and refuses the calls that wait for a picture.
  // `image` resumes when the camera is on again.
  void OnOff();

 private:
  using Request = msg::CameraService::Request;
  using Response = msg::CameraService::Response;
  using Reply = transport::Server<msg::CameraService>::Reply;

  // A call that waits for the next picture, to save it or to begin a video with it.
  struct WaitingCall {
    Shape shape;
    std::string file;
    bool video = false;
    Reply reply;
    transport::LoopHandlePtr timeout;
  };
  struct Recording {
    Shape shape;
    Pace pace;
    std::string file;
  };
  struct ImageTopic {
    Shape shape;
    Pace pace;
  };

  CameraServer(const Dependencies& dependencies, const ServiceConfig& config, CameraDevice& camera,
               std::unique_ptr<Store> store);
  void OnRequest(const Request& request, Reply reply);
  void OnPicture(const msg::Image& picture);
  void Take(WaitingCall waiting, const msg::Image& picture);
  void Record(const msg::Image& picture);
  void PublishImage(const msg::Image& picture);
  void Await(Shape shape, const std::string& file, bool video, Reply reply);
  void EndRecording(const Reply& reply);
  void Listen();  // while pictures are needed
  Response State() const;
  NewFile FileFor(const std::string& requested, bool video) const;

  struct Execute;

  const Dependencies dependencies_;
  CameraDevice& camera_;
  Shape requested_;
  std::list<WaitingCall> waiting_;
  std::optional<Recording> recording_;
  bool beginning_ = false;  // a video is being opened
  std::optional<ImageTopic> image_;
  transport::Endpoints endpoints_;
  transport::Publisher<msg::Image>* const images_;
  std::shared_ptr<int> alive_ = std::make_shared<int>();
  std::unique_ptr<Store> store_;  // last: its callbacks use the rest
};

}  // namespace musher::camera
