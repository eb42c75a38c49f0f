#include "musher/modules/world/process/world_board.hpp"

#include <algorithm>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/world/process/world_messages.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher_lcm/danger_states_lcmt.hpp"
#include "musher_lcm/file_recv_lcmt.hpp"
#include "musher_lcm/file_send_lcmt.hpp"
#include "musher_lcm/localization_lcmt.hpp"
#include "musher_lcm/robot_control_cmd_lcmt.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::world {
namespace {

constexpr Duration kLiesDownAfter = Milliseconds(500);  // without a frame
constexpr int kHeartbeatMode = -1;                      // of a frame that is no command
constexpr int kOffMode = 0;
constexpr int kLyingMode = 7;
constexpr int kLyingGait = 1;

template <std::size_t N>
std::vector<float> ListOf(const float (&values)[N]) {
  return {std::begin(values), std::end(values)};
}

Result<BoardCommand> CommandOf(const musher_lcm::robot_control_cmd_lcmt& frame) {
  msg::MotionCustomCommand message;
  message.mode = frame.mode;
  message.gait_id = frame.gait_id;
  message.contact = frame.contact;
  message.life_count = frame.life_count;
  message.vel_des = ListOf(frame.vel_des);
  message.rpy_des = ListOf(frame.rpy_des);
  message.pos_des = ListOf(frame.pos_des);
  message.value = frame.value;
  message.duration = frame.duration;
  return FromMessage(message);
}

// The board's bits of the errors of a motor: too hot, over-current, driver; and that it runs.
std::int32_t BoardErrorOf(std::int32_t error) {
  constexpr std::uint32_t kRuns = 2U << 30;
  std::uint32_t board = kRuns;
  if ((error & 1) != 0) board |= 1U << 1;
  if ((error & 2) != 0) board |= 1U << 5;
  if ((error & ~3) != 0) board |= 1U << 2;
  return static_cast<std::int32_t>(board);
}

musher_lcm::robot_control_response_lcmt ResponseOf(const World& world) {
  const msg::BodyState state = ToBodyState(world);
  musher_lcm::robot_control_response_lcmt response{};
  response.mode = state.mode;
  response.gait_id = state.gait_id;
  response.contact = state.contact;
  response.order_process_bar = state.order_process_bar;
  // The faults beyond are in fields of their own.
  constexpr auto kLast = static_cast<std::int8_t>(BoardStatus::kLowBattery);
  response.switch_status = state.switch_status > kLast ? std::int8_t{0} : state.switch_status;
  if (state.ori_error != 0) response.switch_status = static_cast<std::int8_t>(BoardStatus::kDamped);
  response.ori_error = state.ori_error;
  response.footpos_error = state.footpos_error;
  std::transform(state.motor_error.begin(), state.motor_error.end(), response.motor_error,
                 BoardErrorOf);
  return response;
}

musher_lcm::localization_lcmt LocationOf(const World& world) {
  const Body& body = world.body();
  const Pose2& odometry = body.odometry();
  const Attitude& attitude = body.attitude();
  musher_lcm::localization_lcmt location{};
  const auto set = [](float(&to)[3], double x, double y, double z) {
    to[0] = static_cast<float>(x);
    to[1] = static_cast<float>(y);
    to[2] = static_cast<float>(z);
  };
  const Eigen::Vector3d speed_m_s =
      Eigen::AngleAxisd(odometry.yaw_rad, Eigen::Vector3d::UnitZ()) * body.speed();
  set(location.xyz, odometry.position_m.x(), odometry.position_m.y(), attitude.height_m);
  set(location.vxyz, speed_m_s.x(), speed_m_s.y(), speed_m_s.z());
  set(location.rpy, attitude.roll_rad, attitude.pitch_rad, odometry.yaw_rad);
  set(location.omegaBody, body.turn_rate().x(), body.turn_rate().y(), body.turn_rate().z());
  set(location.vBody, body.speed().x(), body.speed().y(), body.speed().z());
  location.timestamp = world.now().count();
  return location;
}

musher_lcm::danger_states_lcmt TemperaturesOf(const Body& body) {
  musher_lcm::danger_states_lcmt states{};
  for (std::size_t i = 0; i < kMotors; ++i) {
    states.motor_temperature[i] = static_cast<float>(body.motor_temperature_c(i));
  }
  return states;
}

}  // namespace

Result<std::unique_ptr<WorldBoard>> WorldBoard::Open(transport::EventLoop& loop, World& world,
                                                     Log log) {
  std::unique_ptr<WorldBoard> board(new WorldBoard(loop, world, std::move(log)));
  const BoardSpec& spec = world.scene().motion_board;
  const auto open = [&](const std::string& url, std::unique_ptr<transport::LcmSocket>& socket,
                        transport::LcmSocket::OnSample on_sample) -> Result<> {
    const auto parsed = transport::ReadLcmUrl(url);
    if (!parsed) return parsed.error();
    auto opened = transport::LcmSocket::Open(
        loop, {parsed.value(), spec.network_interface, spec.ttl}, std::move(on_sample));
    if (!opened) return opened.error();
    socket = std::move(opened).value();
    return Ok();
  };
  const auto ignore = [](const transport::LcmSample&) {};
  Result<> opened = open(spec.response_url, board->responses_, ignore);
  if (opened) opened = open(spec.localization_url, board->locations_, ignore);
  if (opened) {
    opened =
        open(spec.command_url, board->commands_,
             [raw = board.get()](const transport::LcmSample& sample) { raw->OnSample(sample); });
  }
  if (!opened) return opened.error();
  board->log_("the motion board takes commands on " + board->commands_->name());
  return board;
}

void WorldBoard::OnSample(const transport::LcmSample& sample) {
  if (!sample.packet) return;
  if (sample.packet->channel == "user_gait_file") return OnGaitText(sample.packet->data);
  if (sample.packet->channel != "robot_control_cmd") return;
  const auto frame = transport::DecodeLcm<musher_lcm::robot_control_cmd_lcmt>(sample.packet->data);
  const auto command = frame ? CommandOf(frame.value()) : Result<BoardCommand>(frame.error());
  if (command) return Take(command.value());
  // Once, until another reason: a stream of them comes.
  const std::string line = "a body command is refused: " + command.error().message;
  if (std::exchange(refused_, line) != line) log_(line);
}

// The gait of a user: a text of sections, then one of steps. The body does not follow it; motions
// with gait 110 are those of the table.
void WorldBoard::OnGaitText(std::span<const std::byte> data) {
  const auto file = transport::DecodeLcmText<musher_lcm::file_send_lcmt>(data);
  if (!file) return log_("a gait is refused: " + file.error().message);
  const std::string& text = file.value();
  const bool sections = text.starts_with("# Gait Def");
  const bool steps = text.starts_with("# Gait Params");
  const bool accepted = sections || (steps && has_gait_sections_);
  if (sections) has_gait_sections_ = true;
  log_(std::string(sections ? "sections" : "steps") + " of a gait, " + std::to_string(text.size()) +
       " bytes: " + (accepted ? "accepted" : "refused"));
  musher_lcm::file_recv_lcmt result{};
  result.result = accepted ? std::int8_t{0} : std::int8_t{1};
  static_cast<void>(commands_->Send("user_gait_result", transport::EncodeLcm(result)));
}

// The body's counts are the board's own, because it also lies down by itself.
void WorldBoard::Take(BoardCommand command) {
  frame_at_ = {loop_.Now(), world_.now()};
  if (command.mode == kHeartbeatMode && !wire_count_) return;
  if (command.mode != kHeartbeatMode && wire_count_ != command.life_count) {
    wire_count_ = command.life_count;
    count_ = static_cast<std::int8_t>(static_cast<std::uint8_t>(count_) + 1);
  }
  command.life_count = count_;
  if (const auto line = world_.Command(command)) log_(*line);
}

void WorldBoard::LieDownWithoutFrames() {
  if (!frame_at_ || loop_.Now() - frame_at_->real < kLiesDownAfter ||
      world_.now() - frame_at_->world < kLiesDownAfter) {
    return;
  }
  const Body& body = world_.body();
  if (body.mode() == kLyingMode || body.mode() == kOffMode) return frame_at_.reset();
  if (body.in_the_air()) return;
  BoardCommand lie;
  lie.mode = kLyingMode;
  lie.gait = kLyingGait;
  count_ = static_cast<std::int8_t>(static_cast<std::uint8_t>(count_) + 1);
  lie.life_count = count_;
  if (world_.Command(lie)) return;  // refused until its jump has ended
  frame_at_.reset();
  log_("no frame for 500 ms: the body lies down");
}

void WorldBoard::OnStep() {
  LieDownWithoutFrames();
  // Lost ones are followed by the next ones.
  static_cast<void>(
      responses_->Send("robot_control_response", transport::EncodeLcm(ResponseOf(world_))));
  static_cast<void>(locations_->Send("global_to_robot", transport::EncodeLcm(LocationOf(world_))));
  if (world_.now() % std::chrono::seconds(1) >= kStep) return;
  static_cast<void>(
      responses_->Send("motor_temperature", transport::EncodeLcm(TemperaturesOf(world_.body()))));
}

}  // namespace musher::world
