#include "musher/modules/motion/lcm_backend.hpp"

#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion {
namespace {

using transport::LcmOptions;
using transport::LcmSample;
using transport::LcmSocket;

using OpenedSocket = Result<std::unique_ptr<LcmSocket>>;

constexpr Duration kReopenPeriod = std::chrono::seconds(1);
constexpr Duration kAddressesPeriod = Milliseconds(100);

}  // namespace

// Where the host of a sender is does not matter where the config names the board's.
LcmLink::Sender LcmBackend::SenderOf(const LcmSample& sample) {
  LcmLink::Sender sender{sample.sender, sample.packet->sequence};
  sender.age = sample.age;
  if (!config_.board.empty() || link_.IsHostOfBoard(sample.sender)) return sender;
  if (loop_.Now() - addresses_at_ >= kAddressesPeriod) {
    addresses_ = transport::HostAddresses();
    addresses_at_ = loop_.Now();
  }
  sender.place = addresses_.PlaceOf(sample.sender, responses_->network_interface());
  return sender;
}

LcmBackend::LcmBackend(transport::EventLoop& loop, const transport::Clock& clock,
                       const MotionConfig& config, Events events)
    : loop_(loop),
      clock_(clock),
      events_(std::move(events)),
      config_(config.lcm),
      // The caller of a command is answered after board_feedback.
      link_(loop.Now(), LinkOptions{config.board_feedback, config.lcm.board}),
      suspended_(loop.TimeSuspended()) {
  opened_ = Open();
  Arm();
  reopened_at_ = loop_.Now();
  reopen_timer_ = loop_.Every(kReopenPeriod, [this] { Reopen(); });
}

// All sockets, or none. Those of a board that has responded stay on their interfaces: when the
// cable to it fails, the route to the groups may be that to another robot.
Result<> LcmBackend::Open() {
  const auto open = [&](const std::string& url, const std::unique_ptr<LcmSocket>& before,
                        void (LcmBackend::*on_sample)(const LcmSample&)) -> OpenedSocket {
    const auto parsed = transport::ReadLcmUrl(url);
    if (!parsed) return parsed.error();
    const std::string& interface =
        before && link_.HasResponded() ? before->network_interface() : config_.network_interface;
    return LcmSocket::Open(loop_, LcmOptions{parsed.value(), interface, config_.ttl},
                           [this, on_sample](const LcmSample& s) { (this->*on_sample)(s); });
  };
  auto commands = open(config_.command_url, commands_, &LcmBackend::OnCommandGroup);
  auto responses = open(config_.response_url, responses_, &LcmBackend::OnResponseGroup);
  auto locations = open(config_.localization_url, locations_, &LcmBackend::OnLocationGroup);
  for (const OpenedSocket* socket : {&commands, &responses, &locations}) {
    if (!*socket) return Error{MotionCode(KeyCode::kNetError), socket->error().message};
  }
  commands_ = std::move(commands).value();
  responses_ = std::move(responses).value();
  locations_ = std::move(locations).value();
  opened_at_ = loop_.Now();
  return Ok();
}

void LcmBackend::Reopen() {
  const Time now = loop_.Now();
  const Duration since = now - std::exchange(reopened_at_, now);
  if (since > kReopenPeriod + kReopenPeriod / 10) return;  // it hung: what waits is read first
  opened_ = commands_ && !link_.Silent(now) ? Ok() : Open();
  if (!opened_) Handle(link_.OnSendFailed(opened_.error(), now));
}

std::string LcmBackend::Source() const {
  return std::string(kResponseChannel) + " of " +
         (responses_ ? responses_->name() : config_.response_url);
}

Time LcmBackend::Now() {
  const Duration suspended = loop_.TimeSuspended();
  link_.OnSuspended(suspended - std::exchange(suspended_, suspended));
  return loop_.Now();
}

void LcmBackend::Send(const BodyCommand& command) {
  Handle(link_.OnCommand(command, Now()));
}

// Of a message in several datagrams only the first one has a channel; other programs may send such
// messages on channels of their own.
void LcmBackend::OnNoMessage(const LcmSample& sample, const char* channel) {
  if (sample.fragment && sample.fragment->channel != channel) return;
  const std::size_t size = sample.fragment ? sample.fragment->message_size : sample.size;
  Handle(link_.OnMalformed(
      channel,
      std::to_string(size) + " bytes are " + (sample.fragment ? "too long" : "no LCM message"),
      Now()));
}

void LcmBackend::OnCommandGroup(const LcmSample& sample) {
  if (sample.sender == commands_->sender()) return;
  const Time now = Now();
  const bool long_gait = sample.fragment && sample.fragment->channel == kGaitFileChannel;
  if (long_gait) return OnOtherGait(sample.sender);
  if (!sample.packet) return OnNoMessage(sample, kCommandChannel);
  if (sample.packet->channel == kGaitResultChannel) return OnGaitResult(sample);
  if (sample.packet->channel == kGaitFileChannel) return OnOtherGait(sample.sender);
  if (sample.packet->channel != kCommandChannel) return;
  const auto frame = DecodeCommand(sample.packet->data);
  Handle(frame ? link_.OnOtherFrame(sample.sender, frame.value(), now)
               : link_.OnMalformed(kCommandChannel, frame.error().message, now));
}

// --- gaits of users ---

void LcmBackend::DefineGait(const UserGait& gait, OnDefined then) {
  GaitDefinition::Output output = definition_.Begin(gait, loop_.Now());
  if (output.ended) return then(*output.ended);
  on_defined_ = std::move(then);
  Handle(std::move(output));
}

void LcmBackend::OnGaitResult(const LcmSample& sample) {
  const auto accepted = DecodeGaitResult(sample.packet->data);
  if (!accepted) {
    return Handle(link_.OnMalformed(kGaitResultChannel, accepted.error().message, loop_.Now()));
  }
  if (!link_.IsOnHostOfBoard(SenderOf(sample))) return;
  if (std::exchange(answers_of_, sample.sender) != sample.sender) answers_ = {};
  const NewestOnly::Age age = answers_.Take(sample.packet->sequence, loop_.Now());
  if (age == NewestOnly::Age::kOld) return;  // or doubled: it would answer to the steps, too
  Handle(definition_.OnAnswer(accepted.value(), loop_.Now()));
}

void LcmBackend::OnOtherGait(const std::string& sender) {
  Handle(definition_.OnOtherText(sender, loop_.Now()));
  events_.on_other_gait("another program has given the motion board a gait: " + sender +
                        "; define yours again");
}

void LcmBackend::Handle(GaitDefinition::Output output) {
  if (output.text) {
    const auto bytes = EncodeGaitFile(*output.text);
    Result<> sent = bytes ? opened_ : bytes.error();
    if (sent) sent = commands_->Send(kGaitFileChannel, bytes.value());
    if (!sent) output = definition_.OnSendFailed(sent.error());
  }
  answer_timer_.reset();
  if (const auto deadline = definition_.NextDeadline()) {
    answer_timer_ = loop_.At(*deadline, [this] { Handle(definition_.OnTime(loop_.Now())); });
  }
  if (output.ended) std::exchange(on_defined_, nullptr)(*output.ended);
}

// --- the board ---

void LcmBackend::OnResponseGroup(const LcmSample& sample) {
  const Time now = Now();
  if (!sample.packet) return OnNoMessage(sample, kResponseChannel);
  const auto& [sequence, channel, data] = *sample.packet;
  if (channel == kResponseChannel) {
    const auto report = DecodeResponse(data);
    Handle(report ? link_.OnResponse(SenderOf(sample), report.value(), now)
                  : link_.OnMalformed(kResponseChannel, report.error().message, now));
  } else if (channel == kTemperatureChannel) {
    const auto temperatures = DecodeTemperatures(data);
    Handle(temperatures
               ? link_.OnTemperatures(SenderOf(sample), temperatures.value(), now)
               : link_.OnMalformed(kTemperatureChannel, temperatures.error().message, now));
  }
}

void LcmBackend::OnLocationGroup(const LcmSample& sample) {
  const Time now = Now();
  if (!sample.packet) return OnNoMessage(sample, kLocalizationChannel);
  if (sample.packet->channel == kMotorChannel) {
    constexpr std::size_t kMotorFrame = 248;  // bytes; a board drops another one
    const std::size_t size = sample.packet->data.size();
    return Handle(size == kMotorFrame
                      ? link_.OnMotorFrame(sample.sender, now)
                      : link_.OnMalformed(kMotorChannel, std::to_string(size) + " bytes", now));
  }
  if (sample.packet->channel != kLocalizationChannel) return;
  const auto location = DecodeLocation(sample.packet->data);
  if (!location) {
    return Handle(link_.OnMalformed(kLocalizationChannel, location.error().message, now));
  }
  const Duration stamp = msg::FromStamp(clock_.Stamp());
  Handle(link_.OnLocation(SenderOf(sample), location.value(), stamp, now));
}

void LcmBackend::Handle(const LinkOutput& output) {
  for (const BodyCommand& frame : output.frames) Transmit(frame);
  for (const LinkFault& fault : output.faults) events_.on_fault(fault.code, fault.text);
  if (output.restarted) events_.on_restart();
  if (output.held_by) events_.on_held(*output.held_by);
  if (output.body) events_.on_body(*output.body);
  Arm();
}

void LcmBackend::Transmit(const BodyCommand& frame) {
  if (!commands_) return;  // Reopen() reports it
  const auto sent = commands_->Send(kCommandChannel, EncodeCommand(frame));
  if (sent) return;
  for (const LinkFault& fault : link_.OnSendFailed(sent.error(), loop_.Now()).faults) {
    events_.on_fault(fault.code, fault.text);
  }
}

void LcmBackend::Arm() {
  const Time deadline = link_.NextDeadline();
  if (timer_ && deadline == armed_for_) return;
  armed_for_ = deadline;
  timer_ = loop_.At(deadline, [this] {
    armed_for_ = Time{};
    Handle(link_.OnTime(Now()));
  });
}

}  // namespace musher::motion
