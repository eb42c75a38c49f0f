#include "musher/modules/motion/tool/streaming.hpp"

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

std::variant<std::unique_ptr<Streaming>, ExitCode> Streaming::Open(const GlobalOptions& global,
                                                                   std::int32_t id,
                                                                   std::int32_t source) {
  auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  auto stream = ServoStream::Open(*link.value(), id, source);
  if (!stream) return Fail(ExitCode::kUsage, stream.error());
  std::unique_ptr<Streaming> streaming(new Streaming());
  streaming->link_ = std::move(link).value();
  streaming->stream_ = std::move(stream).value();
  program::ToolLink& found = *streaming->link_;
  if (!found.RunUntil([&] { return streaming->stream_->Ready(); }, found.discovery())) {
    return found.TakeInterrupt() ? Interrupted()
                                 : Fail(ExitCode::kNotDone, found.NotFound("motion manager"));
  }
  if (!found.AwaitClock()) {
    return found.TakeInterrupt()
               ? Interrupted()
               : Fail(ExitCode::kNotDone, {kCodeNetError, "no publisher of /clock"});
  }
  return streaming;
}

std::optional<ExitCode> Streaming::Run(Next next, Duration longest, const std::string& what) {
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

void Streaming::Frame(const Next& next) {
  if (over_ || stream_->refusal()) return;
  if (const auto speed = next()) return stream_->Send(*speed);
  over_ = true;
}

}  // namespace musher::motion::tool
