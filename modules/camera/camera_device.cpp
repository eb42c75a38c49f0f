#include "musher/modules/camera/camera_device.hpp"

#include <numbers>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/camera/camera_code.hpp"
#include "musher/modules/camera/camera_info.hpp"
#include "musher/modules/camera/fit.hpp"

namespace musher::camera {

CameraDevice::CameraDevice(const Dependencies& dependencies, const CameraConfig& camera,
                           const CamerasConfig& config)
    : dependencies_(dependencies),
      camera_(camera),
      core_(camera, config.silence, config.retry),
      endpoints_(dependencies.node, dependencies.name_space) {
  const transport::WriterCallbacks watched{[this] { Reconsider(); }};
  pictures_ = endpoints_.Advertise<msg::Image>(camera_.topic, transport::kSensorDataQos, watched);
  infos_ = endpoints_.Advertise<msg::CameraInfo>(camera_.topic + "/camera_info",
                                                 transport::kSensorDataQos, watched);
}

Result<std::unique_ptr<CameraDevice>> CameraDevice::Make(const Dependencies& dependencies,
                                                         const CameraConfig& camera,
                                                         const CamerasConfig& config) {
  std::unique_ptr<CameraDevice> device(new CameraDevice(dependencies, camera, config));
  if (!device->endpoints_.opened()) return device->endpoints_.opened().error();
  return device;
}

void CameraDevice::SetOn(bool on) {
  on_ = on;
  Reconsider();
}

void CameraDevice::SetChecked(bool checked) {
  checked_ = checked;
  Reconsider();
}

void CameraDevice::SetUsed(bool used) {
  used_ = used;
  Reconsider();
}

bool CameraDevice::Watched() const {
  return pictures_->MatchedReaders() > 0 || infos_->MatchedReaders() > 0;
}

void CameraDevice::Reconsider() {
  const bool wanted = checked_ || (on_ && (!camera_.on_demand || used_ || Watched()));
  Do(core_.Want(wanted, Now()));
}

void CameraDevice::Do(CameraActions actions) {
  if (actions.log) dependencies_.log(*actions.log);
  if (actions.close) {
    source_.reset();
    info_.reset();
  }
  if (actions.open) Open();
  Schedule();
}

void CameraDevice::Open() {
  SourceEvents events;
  events.on_frame = [this](msg::Image picture) { OnFrame(std::move(picture)); };
  events.on_info = [this](const msg::CameraInfo& info) {
    info_ = info;
    core_.OnAnnounced(info.width, info.height);
  };
  events.on_failed = [this](const Error& error) { Fail(error); };
  events.on_ended = [this] { Later([this] { Do(core_.OnEnded(Now())); }); };
  auto source = dependencies_.open(camera_, events);
  if (source) {
    source_ = std::move(source).value();
  } else {
    Fail(source.error());
  }
}

// The posted work destroys the source, which must not happen in its own callback.
void CameraDevice::Fail(const Error& error) {
  Later([this, error] { Do(core_.OnFailed(error, Now())); });
}

void CameraDevice::Later(std::function<void()> work) {
  dependencies_.node.loop().Post([alive = std::weak_ptr(alive_), work = std::move(work)] {
    if (alive.lock()) work();
  });
}

void CameraDevice::OnFrame(msg::Image picture) {
  if (Result<> good = CheckPicture(picture); !good) return Fail(good.error());
  if (picture.header.stamp == msg::Stamp{}) picture.header.stamp = dependencies_.stamp();
  CameraActions actions = core_.OnFrame(
      {FromStamp(picture.header.stamp).count(), picture.width, picture.height}, Now());
  const bool publish = actions.publish;
  Do(std::move(actions));
  if (publish) Publish(std::move(picture));
}

void CameraDevice::Publish(msg::Image picture) {
  if (!listener_ && !Watched()) return;
  picture.header.frame_id = camera_.frame_id;
  auto fitted = Fit(std::move(picture), camera_.format);
  if (!fitted) return Fail(fitted.error());
  const msg::Image& image = fitted.value();
  if (pictures_->MatchedReaders() > 0) static_cast<void>(pictures_->Publish(image));
  if (infos_->MatchedReaders() > 0) PublishInfo(image);
  if (const auto listener = listener_) listener(image);  // it may replace the listener
}

void CameraDevice::PublishInfo(const msg::Image& picture) {
  msg::CameraInfo info;
  if (info_) {
    info = Scaled(*info_, picture.width, picture.height);
  } else if (camera_.hfov_deg > 0) {
    info = Pinhole(picture.width, picture.height, camera_.hfov_deg * std::numbers::pi / 180);
  } else {
    return;  // unknown
  }
  info.header = picture.header;
  static_cast<void>(infos_->Publish(info));
}

void CameraDevice::Schedule() {
  timer_.reset();
  const auto at = core_.NextTick();
  if (!at) return;
  timer_ = dependencies_.node.loop().At(*at, [this] { Do(core_.Tick(Now())); });
}

Result<> CameraDevice::Check() const {
  if (core_.fault()) {
    return Error{core_.fault()->code, core_.fault()->text.substr(camera_.name.size() + 2)};
  }
  if (core_.has_given()) return Ok();
  constexpr std::int32_t kCode = CameraCode(KeyCode::kSelfCheckFailed);
  return Error{kCode, "no picture from " + camera_.from};
}

}  // namespace musher::camera
