#include "musher/modules/motion/tool/speed_stream.hpp"

#include <chrono>
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
  stream->breaks_.emplace(found.node().loop());
  if (!found.Find([&] { return stream->stream_->Ready(); })) {
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
  // After each event of the loop: the clock may stand.
  const auto over = [&] {
    CheckBreak();
    return over_ || broken_off_.has_value() || stream_->refusal().has_value();
  };
  link_->RunUntil(over, longest);
  stream_->End();
  const bool interrupted = link_->TakeInterrupt();
  link_->RunUntil([&] { return stream_->ended(); }, kEndTimeout);
  if (broken_off_) {
    return Fail(ExitCode::kNotDone,
                {kCodeTimeout, what + ": this command could not run for " +
                                   std::to_string(ToMilliseconds(*broken_off_) / 1000) +
                                   " s; the body was stopped then, and does not walk on"});
  }
  if (const auto& refusal = stream_->refusal()) {
    return Fail(ExitCode::kNotDone, {refusal->code, what + ": " + refusal->message});
  }
  if (interrupted) return Interrupted();
  if (!over_) return Fail(ExitCode::kNotDone, {kCodeTimeout, what + " did not end in time"});
  return std::nullopt;
}

void SpeedStream::CheckBreak() {
  if (const auto length = breaks_->Take()) broken_off_ = length;
}

void SpeedStream::Frame(const Next& next) {
  CheckBreak();
  if (over_ || broken_off_ || stream_->refusal()) return;
  if (const auto speed = next()) return stream_->Send(*speed);
  over_ = true;
}

}  // namespace musher::motion::tool
