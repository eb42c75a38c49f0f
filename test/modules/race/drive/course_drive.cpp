#include "musher/test/modules/race/drive/course_drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/messages/yaw.hpp"
#include "musher/modules/race/course_for_hall.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::race::testing {
namespace {

constexpr Duration kSpoken = Milliseconds(900);
constexpr double kTickHz = 20;  // of the race and of the walker, as in their processes
constexpr double kRateHz = 15;  // of the cameras, of which a detector takes its share
constexpr std::array<std::string_view, world::kCameras> kTopics{"image_rgb", "image_left",
                                                                "image_right"};

std::string Config(const std::string& name) {
  return SourceDir() + "/config/" + name;
}

// A file of the product that is not right is a fault of the product.
template <class Reading>
auto Valid(const Reading& reading, const auto& value) {
  std::string all;
  for (const Diagnostic& each : reading.diagnostics) all += FormatDiagnostic(each) + "\n";
  if (!value) throw std::runtime_error(all);
  return *value;
}

world::Scene SceneOf(const DriveSettings& settings) {
  const auto reading = world::ReadSceneFile(Config("scenes/course.toml"),
                                            {.seed = settings.seed, .chosen = settings.chosen});
  world::Scene scene = Valid(reading, reading.scene);
  if (settings.slip) scene.body.slip = *settings.slip;
  if (settings.pose) scene.start = *settings.pose;
  if (settings.hall) {
    LayOut(settings.hall->hall, settings.hall->s, scene);
    Furnish(settings.hall->flooring, settings.seed, scene);
    Illuminate(settings.hall->light, scene);
  }
  for (world::Ball& ball : scene.balls) {
    if (ball.name != "yellow light") continue;
    if (settings.light_at_m) ball.center_m.head<2>() = *settings.light_at_m;
    if (!settings.yellow_light && !settings.light_at_m) continue;
    ball.show_within_m = 1.1;
    ball.show_for = std::chrono::seconds(6);
  }
  return scene;
}

std::string TextOf(const std::string& file) {
  const Result<std::string> text = config_toml::ReadModuleText(Config(file));
  if (!text) throw std::runtime_error(text.error().message);
  return text.value();
}

Course BaseOf(const DriveSettings& settings) {
  const auto reading = ReadCourseFile(Config(settings.course));
  return Valid(reading, reading.course);
}

line_walker::WalkerConfig WalkerOf(const DriveSettings& settings) {
  std::string text = TextOf("line_walker/walker.toml");
  if (settings.hall) text = WalkerForHall(settings.hall->hall, text).text;
  const auto reading = line_walker::ReadWalkerText(text, Config("line_walker/walker.toml"));
  return Valid(reading, reading.config);
}

vision::VisionConfig VisionOf(const DriveSettings& settings) {
  std::string text = TextOf("vision/course.toml");
  if (settings.hall) text = VisionForHall(settings.hall->hall, BaseOf(settings).hall, text).text;
  const auto reading = vision::ReadVisionText(text, Config("vision/course.toml"));
  return Valid(reading, reading.config);
}

// With short waits where it only waits: a minute of standing shows nothing.
Course CourseOf(const DriveSettings& settings) {
  Course course = BaseOf(settings);
  if (settings.hall) {
    const AdaptedFile file = CourseForHall(settings.hall->hall, course, TextOf(settings.course));
    const auto reading = ReadCourseText(file.text, Config(settings.course));
    course = Valid(reading, reading.course);
  }
  for (Wait& wait : course.waits) {
    if (!wait.detector) wait.limit = std::min(wait.limit, Milliseconds(2000));
  }
  return course;
}

// Of this thread.
Duration CpuTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

vision::floors::Material MaterialOf(Flooring flooring) {
  using vision::floors::Material;
  switch (flooring) {
    case Flooring::kOak:
      return Material::kOak;
    case Flooring::kTiles:
      return Material::kConcrete;
    case Flooring::kBlueMat:
      return Material::kBlueMat;
    case Flooring::kWetSpots:
      return Material::kWet;
    case Flooring::kGrey:
    case Flooring::kShipped:
      break;
  }
  return Material::kGrey;
}

HallPaint PaintOf(const OtherHall& hall, std::uint64_t seed) {
  HallPaint paint;
  paint.floor.material = MaterialOf(hall.flooring);
  paint.floor.light = {hall.light.temperature_k, hall.light.share, false};
  paint.floor.seed = seed;
  return paint;
}

}  // namespace

CourseDrive::CourseDrive(DriveSettings settings)
    : settings_(std::move(settings)),
      dog_(SceneOf(settings_),
           settings_.over_lcm ? SimulatedDog::Wire::kLcm : SimulatedDog::Wire::kNone),
      walker_config_(WalkerOf(settings_)),
      walker_(walker_config_.walk),
      race_(CourseOf(settings_), *this) {
  const world::Scene& scene = dog_.world().scene();
  scenery_ = world::Scenery::Make(scene).value();
  const bool painted = settings_.hall && settings_.hall->flooring != Flooring::kShipped;
  if (painted) std::filesystem::remove(scene.ground.file);
  if (settings_.hall && settings_.hall->painted) {
    painter_.emplace(scene, PaintOf(*settings_.hall, settings_.seed));
  }
  for (std::size_t i = 0; i < cameras_.size(); ++i) cameras_[i].emplace(scene.cameras.cameras[i]);
  for (const vision::CourseEntry& entry : VisionOf(settings_).detectors) {
    DetectorChannel channel{
        entry, entry.factory.make().value(), vision::StampGate(entry.rate_hz), 0, {}, {}, false,
        {}};
    const auto camera = std::find(kTopics.begin(), kTopics.end(), entry.picture);
    channel.camera = static_cast<std::size_t>(camera - kTopics.begin());
    const vision::CourseOutputs outputs = entry.Outputs();
    const std::string topic = outputs.lines ? *outputs.lines : *outputs.sighting;
    for (Index i = 0; i < race_.course().detectors.size(); ++i) {
      if (race_.course().detectors[i].topic == topic) channel.of_race = i;
    }
    const auto& names = walker_config_.topics;
    if (topic == names.left) channel.of_walker = line_walker::View::kLeft;
    if (topic == names.right) channel.of_walker = line_walker::View::kRight;
    if (topic == names.front) channel.of_walker = line_walker::View::kFront;
    channels_.push_back(std::move(channel));
  }
  dog_.on_servo_reply = [this](const msg::MotionServoResponse& reply) {
    race_.OnServoReply(reply.result, reply.code, dog_.now());
    walker_.OnResponse(reply, dog_.now());
  };
  if (const Result<> built = race_.Build(machine_); !built) {
    throw std::runtime_error(built.error().message);
  }
}

CourseDrive::~CourseDrive() = default;

DriveResult CourseDrive::Run() {
  race_.Resume(dog_.now());
  static_cast<void>(machine_.Start(dog_.now()));
  for (int i = 0; i < 50; ++i) Step();
  race_.OnCommand(settings_.from.empty() ? "START" : "START:" + settings_.from, dog_.now());
  const auto& course = race_.course();
  const Time begun = dog_.now();
  while (dog_.now() - begun < settings_.limit) {
    Step();
    const std::string_view state = race_.state();
    if (state == course.states[course.end].name || state == course.states[course.error].name ||
        state == settings_.until) {
      break;
    }
  }
  // What the last state does; that of `until` has just begun.
  const int more = race_.state() == settings_.until ? 0 : 50 * 8;
  for (int i = 0; i < more; ++i) Step();
  result_.took = dog_.now() - begun;
  result_.state = race_.state();
  const std::string info = race_.InfoText();
  constexpr std::string_view kReason = ",Reason:";
  if (const auto at = info.find(kReason); at != std::string::npos) {
    result_.reason = info.substr(at + kReason.size());
  }
  const Memory& memory = race_.memory();
  for (Index i = 0; i < course.results.size(); ++i) {
    const auto chosen = settings_.chosen.find(course.results[i].name);
    if (chosen == settings_.chosen.end() || !memory.Value(i) || memory.IsDefault(i)) continue;
    if (memory.Text(i) == chosen->second) continue;
    result_.wrong_words.push_back(course.results[i].name + " is " + memory.Text(i));
  }
  result_.pictures = shots_;
  for (const Reservation& each : race_.memory().reservations()) {
    result_.reservations.push_back(each.Text());
  }
  result_.datagrams = dog_.datagrams();
  result_.world = dog_.world();
  return std::move(result_);
}

std::vector<std::string> CourseDrive::LinesFrom(const world::Pose2& pose) {
  std::vector<std::string> found;
  for (DetectorChannel& channel : channels_) {
    if (channel.entry.kind != vision::CourseKind::kLines) continue;
    const cv::Mat picture = PictureFrom(channel.camera, pose);
    const vision::CourseSight sight = channel.detector->Look(picture, 1, std::nullopt);
    const msg::YellowLines& lines = *sight.lines;
    found.push_back(fmt::format("{:12} {} lines, ycy {:6} {:+.3f}, dy {:6} {:+.3f} {}",
                                channel.entry.name, lines.contours, lines.ycy, lines.middle_offset,
                                lines.dy, lines.line_offset, lines.doubt));
    if (settings_.pictures.empty()) continue;
    cv::Mat drawn = picture.clone();
    channel.detector->Draw(drawn);
    cv::imwrite(settings_.pictures + "/" + channel.entry.name + ".png", drawn);
  }
  return found;
}

msg::YellowLines CourseDrive::LinesFrom(Index detector, const world::Pose2& pose) {
  for (DetectorChannel& channel : channels_) {
    if (channel.of_race != detector) continue;
    return channel.detector->Look(PictureFrom(channel.camera, pose), 1, std::nullopt).lines.value();
  }
  throw std::runtime_error("no detector of the race");
}

void CourseDrive::Step() {
  dog_.Step();
  for (; logged_by_dog_ < dog_.log().size(); ++logged_by_dog_) {
    Log("motion", dog_.log()[logged_by_dog_]);
  }
  const std::size_t feet = dog_.world().referee().whole_foot_count();
  if (feet > std::exchange(feet_, feet)) Log("referee", "a foot is wholly on a line");
  const Time now = dog_.now();
  const msg::Odometry odometry = dog_.odometry();
  walker_.OnOdometry(odometry, now);
  const msg::Pose& pose = odometry.pose.pose;
  race_.OnOdometry(msg::FromStamp(odometry.header.stamp).count(),
                   {{pose.position.x, pose.position.y}, msg::YawOf(pose.orientation)}, now, now);
  Deliver();
  LookAround();
  if (world::IsDue(dog_.world().now(), 10)) {
    race_.OnBody(dog_.body_status(), dog_.present_motion(), now);
    for (Index i = 0; i < race_.course().walks.size(); ++i) {
      race_.OnWalkerStatus(i, walker_.StatusText(now), now);
    }
  }
  if (world::IsDue(dog_.world().now(), kTickHz)) TickWalker();
  if (world::IsDue(dog_.world().now(), kTickHz)) TickRace(now);
  if (settings_.on_step) settings_.on_step(dog_.world(), walker_.active());
}

void CourseDrive::TickRace(Time now) {
  const std::size_t decisions = result_.latencies.of_race.size();
  const Duration begun = CpuTime();
  machine_.RunOnce(now);
  race_.AfterTick();
  if (result_.latencies.of_race.size() > decisions) {
    result_.latencies.race_cpu.push_back(CpuTime() - begun);
  }
  race_.PassTime(now);
}

cv::Mat CourseDrive::PictureOf(std::size_t camera, const world::View& view) const {
  if (painter_) return painter_->Taken(camera, view);
  const world::Image image = cameras_[camera]->Shoot(*scenery_, view);
  return cv::Mat(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.bgr.data()))
      .clone();
}

// Of a standing robot.
cv::Mat CourseDrive::PictureFrom(std::size_t camera, const world::Pose2& pose) const {
  world::View view = world::ViewOf(dog_.world(), camera);
  view.body = pose;
  view.attitude = {dog_.world().scene().body.stand_height_m, 0, 0};
  return PictureOf(camera, view);
}

bool CourseDrive::Wanted(const DetectorChannel& channel) const {
  return channel.wanted_by_race || (channel.of_walker && walker_.active());
}

void CourseDrive::LookAround() {
  if (!world::IsDue(dog_.world().now(), kRateHz)) return;
  const std::int64_t stamp_ns = dog_.world().now().count();
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    std::optional<cv::Mat> picture;
    for (DetectorChannel& channel : channels_) {
      if (channel.camera != camera || !Wanted(channel)) continue;
      using Verdict = vision::StampGate::Verdict;
      const Verdict verdict = channel.gate.Check(stamp_ns);
      if (verdict != Verdict::kLook && verdict != Verdict::kLookAfterJump) continue;
      if (!picture) {
        picture = PictureOf(camera, world::ViewOf(dog_.world(), camera));
        ++shots_;
      }
      Look(channel, *picture);
    }
  }
}

void CourseDrive::Look(DetectorChannel& channel, const cv::Mat& picture) {
  const Time taken = dog_.now();
  const world::Intrinsics& intrinsics = cameras_[channel.camera]->intrinsics();
  vision::Lens lens;
  lens.fisheye = intrinsics.model == world::CameraModel::kFisheye;
  lens.focal_x = intrinsics.focal_px / intrinsics.width_px;
  lens.focal_y = intrinsics.focal_px / intrinsics.height_px;
  vision::CourseSight sight =
      channel.detector->Look(picture, taken.time_since_epoch().count(), lens);
  if (!settings_.pictures.empty()) {
    cv::Mat drawn = picture.clone();
    channel.detector->Draw(drawn);
    cv::imwrite(fmt::format("{}/{:07.2f}-{}-{}.jpg", settings_.pictures,
                            ToSeconds(taken.time_since_epoch()), race_.state(), channel.entry.name),
                drawn);
  }
  Later(settings_.latency, [this, &channel, sight = std::move(sight), taken] {
    const Time now = dog_.now();
    if (sight.lines) {
      msg::YellowLines lines = *sight.lines;
      lines.header.stamp = msg::ToStamp(taken.time_since_epoch());
      if (channel.wanted_by_race) {
        race_.OnLines(*channel.of_race, lines.contours, lines.ycy, lines.dy, lines.middle_offset,
                      taken, now, lines.doubt);
      }
      if (channel.wanted_by_race) channel.shown_to_race = taken;
      if (channel.of_walker) ShowWalker(*channel.of_walker, lines, taken);
    } else if (sight.sighting && channel.wanted_by_race) {
      msg::Sighting seen = *sight.sighting;
      if (settings_.unseen.contains(race_.course().detectors[*channel.of_race].name)) seen = {};
      race_.OnSighting(*channel.of_race,
                       {seen.seen, seen.distance_m, seen.phase, seen.text,
                        seen.x + seen.width / 2 - 0.5, seen.confidence},
                       taken, now);
      channel.shown_to_race = taken;
    } else if (channel.wanted_by_race && channel.of_race && !sight.doubt.empty()) {
      race_.OnDoubt(*channel.of_race, sight.doubt, now);
    }
  });
}

void CourseDrive::ShowWalker(line_walker::View view, const msg::YellowLines& lines, Time taken) {
  const Duration begun = CpuTime();
  walker_.OnLines(view, lines, dog_.now());
  if (!walker_.active()) return;
  walker_cpu_ += CpuTime() - begun;
  shown_to_walker_ = taken;
}

void CourseDrive::Deliver() {
  std::vector<Due> left;
  std::vector<Due> now_due;
  for (Due& due : due_) (due.at <= dog_.now() ? now_due : left).push_back(std::move(due));
  due_ = std::move(left);
  for (const Due& due : now_due) due.work();
}

void CourseDrive::TickWalker() {
  const Duration begun = CpuTime();
  const auto step = walker_.Tick(dog_.now());
  if (!step) return;
  if (shown_to_walker_) {
    result_.latencies.of_walker.push_back(dog_.now() - *shown_to_walker_);
    result_.latencies.walker_cpu.push_back(walker_cpu_ + CpuTime() - begun);
    shown_to_walker_.reset();
    walker_cpu_ = {};
  }
  msg::MotionServoCmd frame;
  frame.motion_id = motion::kUserTrot;
  frame.cmd_type = step->end ? msg::MotionServoCmd::kEnd : msg::MotionServoCmd::kData;
  frame.cmd_source = motion::kFromAlgorithm;
  const auto& v = step->velocity;
  frame.vel_des = {static_cast<float>(v.forward_m_s), static_cast<float>(v.left_m_s),
                   static_cast<float>(v.yaw_rad_s)};
  frame.step_height = {0.05F, 0.05F};
  dog_.Servo(frame);
}

std::string CourseDrive::Where() const {
  const world::Pose2& pose = dog_.world().body().pose();
  return fmt::format("({:.2f}, {:.2f}) {:.0f}°", pose.position_m.x(), pose.position_m.y(),
                     pose.yaw_rad * 180 / M_PI);
}

void CourseDrive::Log(const std::string& who, const std::string& line) {
  const double at_s = ToSeconds(dog_.world().now());
  result_.log.push_back(fmt::format("{:7.2f} {} {}: {}", at_s, Where(), who, line));
  if (settings_.on_log) settings_.on_log(result_.log.back());
}

void CourseDrive::Walk(const ServoFrame& frame) {
  msg::MotionServoCmd sent;
  sent.motion_id = frame.motion_id;
  sent.cmd_type = frame.end ? msg::MotionServoCmd::kEnd : msg::MotionServoCmd::kData;
  sent.cmd_source = motion::kFromAlgorithm;
  sent.vel_des = {static_cast<float>(frame.twist.forward_m_s),
                  static_cast<float>(frame.twist.left_m_s),
                  static_cast<float>(frame.twist.yaw_rad_s)};
  sent.step_height = {static_cast<float>(frame.step_height_m[0]),
                      static_cast<float>(frame.step_height_m[1])};
  dog_.Servo(sent);
}

void CourseDrive::Move(std::int32_t motion_id, std::uint64_t number) {
  // The reply comes later than the call, also a refusal.
  Later({}, [this, motion_id, number] {
    dog_.Play(motion_id, [this, number](std::int32_t code) {
      race_.OnMotionDone(number, code == kCodeOk ? Result<>() : Error{code, "motion failed"},
                         dog_.now());
    });
  });
}

void CourseDrive::CommandWalker(const LaneWalk& walk, bool start) {
  Log("walker", walk.name + (start ? " START" : " STOP: " + walker_.reason()));
  Later({}, [this, start] {
    if (start) {
      walker_.Start(dog_.now());
    } else {
      walker_.Stop(dog_.now());
    }
  });
}

void CourseDrive::Watch(const std::vector<bool>& detectors) {
  for (DetectorChannel& channel : channels_) {
    if (!channel.of_race) continue;
    if (!detectors[*channel.of_race]) {
      // The light is watched while the robot walks; the end of the walk is no decision by it.
      const bool decides = channel.entry.kind != vision::CourseKind::kLight;
      if (channel.shown_to_race && decides)
        result_.latencies.of_race.push_back(dog_.now() - *channel.shown_to_race);
      channel.shown_to_race.reset();
    }
    channel.wanted_by_race = detectors[*channel.of_race];
  }
}

void CourseDrive::Speak(const std::string& text, std::uint64_t number) {
  Log("says", text);
  Later(kSpoken, [this, number] { race_.OnSpoken(number, Ok(), dog_.now()); });
}

void CourseDrive::ShowState(int number) {
  const auto& states = race_.course().states;
  const auto named = std::find_if(states.begin(), states.end(),
                                  [&](const StateRule& rule) { return rule.number == number; });
  if (named == states.end()) return;
  result_.states.push_back(named->name);
  Log("state", named->name);
  dog_.world().SetMachineState(named->name);
  if (settings_.on_state) settings_.on_state(named->name, dog_.world());
}

}  // namespace musher::race::testing
