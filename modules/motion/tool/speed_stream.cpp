#include "musher/modules/motion/tool/speed_stream.hpp"

#include <utility>

#include "musher/modules/motion/tool/commands.hpp"

namespace musher::motion::tool {
namespace {

constexpr Duration kFrame = Milliseconds(50);
constexpr Duration kEndTimeout = Milliseconds(500);  // for the response to the end

ExitCode Interrupted() {
  return Fail(ExitCode::kInterrupted, {kCodeFailed, "interrupted; the body was commanded to stop"});
}

}  // namespace

std::variant<std::unique_ptr<SpeedStream>, ExitCode> SpeedStream::Open(const GlobalOptions& global,
                                                                       std::int32_t id,
                                                                       std::int32_t source) {
  auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  auto frames = ServoStream::Open(*link.value(), id, source);
  if (!frames) return Fail(ExitCode::kUsage, frames.error());
  std::unique_ptr<SpeedStream> stream(new SpeedStream());
  stream->link_ = std::move(link).value();
  stream->stream_ = std::move(frames).value();
  program::ToolLink& found = *stream->link_;
  if (!found.RunUntil([&] { return stream->stream_->Ready(); }, found.discovery())) {
    return found.TakeInterrupt() ? Interrupted()
                                 : Fail(ExitCode::kNotDone, found.NotFound("motion manager"));
  }
  if (!found.AwaitClock()) {
    return found.TakeInterrupt()
               ? Interrupted()
               : Fail(ExitCode::kNotDone, {kCodeNetError, "no publisher of /clock"});
  }
  return stream;
}

std::optional<ExitCode> SpeedStream::Run(Next next, Duration longest, const std::string& what) {
  Frame(next);
  const auto timer = link_->clock().Every(kFrame, [&] { Frame(next); });
  const auto over = [&] { return over_ || stream_->refusal().has_value(); };
  link_->RunUntil(over, longest);
  stream_->End();
  const bool interrupted = link_->TakeInterrupt();
  link_->RunUntil([&] { return stream_->ended(); }, kEndTimeout);
  if (const auto& refusal = stream_->refusal()) {
    return Fail(ExitCode::kNotDone, {refusal->code, what + ": " + refusal->message});
  }
  if (interrupted) return Interrupted();
  if (!over_) return Fail(ExitCode::kNotDone, {kCodeTimeout, what + " did not end in time"});
  return std::nullopt;
}

void SpeedStream::Frame(const Next& next) {
  if (over_ || stream_->refusal()) return;
  if (const auto speed = next()) return stream_->Send(*speed);
  over_ = true;
}

}  // namespace musher::motion::tool
