#include "musher/modules/camera/camera_server.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/camera/fit.hpp"

namespace musher::camera {
namespace {

using msg::CameraService;

// An error of the store as a reply.
CameraService::Response AnswerTo(const Error& error) {
  const auto key = static_cast<KeyCode>(error.code % 100);
  const std::uint8_t result = key == KeyCode::kParametersInvalid ? CameraService::kInvalidArguments
                              : key == KeyCode::kTargetBusy      ? CameraService::kBusy
                                                                 : CameraService::kInnerError;
  return {result, error.message, error.code};
}

CameraService::Response PathOrRefusal(const Result<std::string>& path) {
  return path ? Answer(CameraService::kSuccess, path.value()) : AnswerTo(path.error());
}

// Fits the picture to what a codec takes.
Result<msg::Image> ForFile(const msg::Image& picture, const Shape& shape) {
  return Fit(picture, {shape.width_px, shape.height_px, "bgr8"});
}

std::string Size(const Shape& shape) {
  if (shape.width_px == 0) return "as it comes";
  return std::to_string(shape.width_px) + "x" + std::to_string(shape.height_px);
}

}  // namespace

CameraServer::CameraServer(const Dependencies& dependencies, const ServiceConfig& config,
                           CameraDevice& camera, std::unique_ptr<Store> store)
    : dependencies_(dependencies),
      camera_(camera),
      endpoints_(dependencies.node, dependencies.name_space),
      images_(endpoints_.Advertise<msg::Image>(config.topic, transport::kSensorDataQos)),
      store_(std::move(store)) {
  endpoints_.Serve<CameraService>("camera_service", [this](const Request& request, Reply reply) {
    OnRequest(request, std::move(reply));
  });
}

CameraServer::~CameraServer() {
  camera_.SetListener(nullptr);
}

Result<std::unique_ptr<CameraServer>> CameraServer::Make(const Dependencies& dependencies,
                                                         const ServiceConfig& config,
                                                         CameraDevice& camera,
                                                         std::unique_ptr<Store> store) {
  std::unique_ptr<CameraServer> server(
      new CameraServer(dependencies, config, camera, std::move(store)));
  if (!server->endpoints_.opened()) return server->endpoints_.opened().error();
  return server;
}

struct CameraServer::Execute {
  CameraServer& server;
  Reply reply;

  void operator()(const Response& refusal) {
    server.dependencies_.log({refusal.code, "camera_service: refused: " + refusal.msg});
    reply(refusal);
  }
  void operator()(const SetShape& set) {
    server.requested_ = set.shape;
    reply(Answer(CameraService::kSuccess, ""));
  }
  void operator()(const TakePicture& take) { server.Await(take.shape, take.file, false, reply); }
  void operator()(const StartRecording& start) {
    server.beginning_ = true;
    server.Await(start.shape, start.file, true, reply);
  }
  void operator()(const StopRecording&) { server.EndRecording(reply); }
  void operator()(const ReportState&) { reply(server.State()); }
  void operator()(const DeleteFile& file) {
    server.store_->Delete(file.file, [reply = reply](const Result<>& deleted) {
      reply(deleted ? Answer(CameraService::kSuccess, "") : AnswerTo(deleted.error()));
    });
  }
  void operator()(const ListFiles&) {
    server.store_->List([reply = reply](const Result<std::vector<std::string>>& files) {
      if (!files) return reply(AnswerTo(files.error()));
      std::string text;
      for (const std::string& file : files.value()) text += (text.empty() ? "" : "\n") + file;
      reply(Answer(CameraService::kSuccess, text));
    });
  }
  void operator()(const StartImage& start) {
    server.image_ = ImageTopic{start.shape, Pace(start.shape.rate_hz)};
    server.Listen();
    reply(Answer(CameraService::kSuccess, ""));
  }
  void operator()(const StopImage&) {
    server.image_.reset();
    server.Listen();
    reply(Answer(CameraService::kSuccess, ""));
  }
};

void CameraServer::OnRequest(const Request& request, Reply reply) {
  ServiceState state;
  state.on = camera_.on();
  if (Result<> may = dependencies_.may_be_used(); !may) state.refusal = may.error();
  state.recording = recording_.has_value() || beginning_;
  state.publishing = image_.has_value();
  std::visit(Execute{*this, std::move(reply)}, Decide(request, state, requested_));
}

void CameraServer::Await(Shape shape, const std::string& file, bool video, Reply reply) {
  waiting_.push_back({shape, file, video, std::move(reply), nullptr});
  const auto self = std::prev(waiting_.end());
  transport::EventLoop& loop = dependencies_.node.loop();
  self->timeout = loop.At(loop.Now() + kPictureTime, [this, self] {
    const WaitingCall late = std::move(*self);
    waiting_.erase(self);
    if (late.video) beginning_ = false;
    Listen();
    late.reply(Answer(CameraService::kTimeout, camera_.config().name + ": no picture within " +
                                                   std::to_string(ToMilliseconds(kPictureTime)) +
                                                   " ms"));
  });
  Listen();
}

void CameraServer::Listen() {
  const bool needed = !waiting_.empty() || recording_ || image_;
  if (needed) {
    camera_.SetListener([this](const msg::Image& picture) { OnPicture(picture); });
  } else {
    camera_.SetListener(nullptr);
  }
  camera_.SetUsed(needed);
}

void CameraServer::OnPicture(const msg::Image& picture) {
  if (image_) PublishImage(picture);
  if (recording_) Record(picture);
  if (waiting_.empty()) return;
  for (WaitingCall& waiting : std::exchange(waiting_, {})) Take(std::move(waiting), picture);
  // The listener is not destroyed while it runs.
  dependencies_.node.loop().Post([weak = std::weak_ptr(alive_), this] {
    if (weak.lock()) Listen();
  });
}

void CameraServer::Take(WaitingCall waiting, const msg::Image& picture) {
  auto ready = ForFile(picture, waiting.shape);
  const NewFile file = FileFor(waiting.file, waiting.video);
  if (!ready) {
    beginning_ = beginning_ && !waiting.video;
    return waiting.reply(AnswerTo(ready.error()));
  }
  if (!waiting.video) {
    return store_->Save(
        std::move(ready).value(), file,
        [reply = waiting.reply](const Result<std::string>& path) { reply(PathOrRefusal(path)); });
  }
  Shape shape = {ready.value().width, ready.value().height, waiting.shape.rate_hz};
  if (shape.rate_hz == 0) shape.rate_hz = camera_.config().rate_hz;
  if (shape.rate_hz == 0) shape.rate_hz = kVideoHz;
  Pace pace(shape.rate_hz);
  pace.Due(FromStamp(picture.header.stamp).count());
  store_->BeginVideo(
      std::move(ready).value(), file, shape.rate_hz,
      [this, shape, pace, reply = waiting.reply](const Result<std::string>& path) {
        beginning_ = false;
        if (path) {
          recording_ = Recording{shape, pace, std::filesystem::path(path.value()).filename()};
        }
        Listen();
        reply(PathOrRefusal(path));
        if (!camera_.on()) OnOff();  // switched off meanwhile
      });
}

void CameraServer::Record(const msg::Image& picture) {
  if (!recording_->pace.Due(FromStamp(picture.header.stamp).count())) return;
  auto ready = ForFile(picture, recording_->shape);
  if (ready) store_->AddFrame(std::move(ready).value());
}

void CameraServer::EndRecording(const Reply& reply) {
  recording_.reset();
  Listen();
  store_->EndVideo([this, reply](const Result<std::string>& path) {
    if (!path) dependencies_.log({path.error().code, "camera_service: " + path.error().message});
    if (reply) reply(PathOrRefusal(path));
  });
}

void CameraServer::PublishImage(const msg::Image& picture) {
  if (!image_->pace.Due(FromStamp(picture.header.stamp).count())) return;
  if (images_->MatchedReaders() == 0) return;
  const Shape& shape = image_->shape;
  const bool same =
      shape.width_px == 0 || (shape.width_px == picture.width && shape.height_px == picture.height);
  if (same) return static_cast<void>(images_->Publish(picture));
  auto fitted = Fit(picture, {shape.width_px, shape.height_px, ""});
  if (fitted) static_cast<void>(images_->Publish(fitted.value()));
}

void CameraServer::OnOff() {
  for (WaitingCall& waiting : std::exchange(waiting_, {})) {
    if (waiting.video) beginning_ = false;
    waiting.reply(Answer(CameraService::kInvalidState, "the camera was switched off"));
  }
  if (recording_) {
    dependencies_.log({kCodeOk, "camera_service: " + recording_->file +
                                    " is ended: the camera was switched off"});
    EndRecording({});
  }
  Listen();
}

CameraServer::Response CameraServer::State() const {
  std::string text = camera_.config().name + (camera_.on() ? ": on" : ": off");
  if (recording_) text += ", recording " + recording_->file;
  if (image_) text += ", image " + Size(image_->shape);
  return Answer(CameraService::kSuccess, text);
}

// A world's time starts again with each run, so the name may exist already.
NewFile CameraServer::FileFor(const std::string& requested, bool video) const {
  if (!requested.empty()) return {requested};
  const msg::Stamp stamp = dependencies_.stamp();
  std::array<char, 64> name{};
  std::snprintf(name.data(), name.size(), "%s_%d.%03u.%s", video ? "video" : "picture", stamp.sec,
                stamp.nanosec / 1'000'000, video ? "avi" : "jpg");
  return {name.data(), true};
}

}  // namespace musher::camera
