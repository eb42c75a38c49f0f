#include "musher/view/live/camera_view.hpp"

#include "musher/view/live/watched_topics.hpp"

namespace musher::view {
namespace {

constexpr Duration kLookPeriod = Milliseconds(250);

}  // namespace

void CameraView::Get(const std::string& topic, std::int64_t after_ms, int width,
                     const http::Respond& respond) {
  const auto source = table_.SourceOf(topic);
  if (!source || !IsPicture(source->dds_type)) {
    return respond(
        http::ErrorResponse(404, kCodeParametersInvalid,
                            source ? topic + " has no pictures: its type is " + source->dds_type
                                   : "no process publishes " + topic));
  }
  Camera& camera = cameras_[topic];
  if (!camera.reader || camera.source != *source) {
    camera.reader.reset();
    camera.source = *source;
    transport::ReaderCallbacks callbacks;
    callbacks.on_sample = [this, &camera](std::span<const std::byte> bytes,
                                          const transport::SampleInfo&) {
      OnPicture(camera, bytes);
    };
    transport::Qos qos = source->qos;
    qos.depth = 1;
    auto reader = node_.MakeRawReader("rt" + topic, source->dds_type, qos, std::move(callbacks));
    if (!reader) {
      return respond(http::ErrorResponse(500, reader.error().code, reader.error().message));
    }
    camera.reader = std::move(reader).value();
  }
  const Time now = node_.loop().Now();
  camera.requested_at = now;
  if (!timer_) timer_ = node_.loop().Every(kLookPeriod, [this] { Look(); });
  if (camera.stamp_ms > after_ms) return Answer(camera, width, respond);
  camera.waiting.push_back({after_ms, width, respond, now + kTimeout});
}

void CameraView::OnPicture(Camera& camera, std::span<const std::byte> bytes) {
  camera.newest.assign(bytes.begin(), bytes.end());
  camera.stamp_ms = std::max(WallMilliseconds(), camera.stamp_ms + 1);
  camera.jpegs.clear();
  std::list<Request> waiting;
  waiting.swap(camera.waiting);
  for (Request& request : waiting) {
    if (camera.stamp_ms > request.after_ms) {
      Answer(camera, request.width, request.respond);
    } else {
      camera.waiting.push_back(std::move(request));
    }
  }
}

void CameraView::Answer(Camera& camera, int width, const http::Respond& respond) {
  std::shared_ptr<const std::string>& jpeg = camera.jpegs[width];
  if (!jpeg) {
    auto made = JpegOf(camera.source.dds_type, camera.newest, width);
    if (!made) return respond(http::ErrorResponse(415, made.error().code, made.error().message));
    jpeg = std::make_shared<const std::string>(std::move(made).value());
  }
  http::Response response;
  response.content_type = "image/jpeg";
  response.body = jpeg;
  response.headers.emplace_back("X-Stamp-Ms", std::to_string(camera.stamp_ms));
  response.headers.emplace_back("Cache-Control", "no-store");
  respond(std::move(response));
}

void CameraView::Look() {
  const Time now = node_.loop().Now();
  for (auto& [topic, camera] : cameras_) {
    for (auto request = camera.waiting.begin(); request != camera.waiting.end();) {
      if (now < request->until) {
        ++request;
        continue;
      }
      http::Response none;
      none.status = 204;
      request->respond(std::move(none));
      request = camera.waiting.erase(request);
    }
  }
  std::erase_if(cameras_, [now](const auto& camera) {
    return camera.second.waiting.empty() && now - camera.second.requested_at > kKept;
  });
  if (cameras_.empty()) timer_.reset();
}

}  // namespace musher::view
