#pragma once
// One call of a service, to its end.

#include <optional>
#include <string>
#include <utility>

#include "musher/modules/audio/tool/commands.hpp"
#include "musher/transport/service.hpp"

namespace musher::audio::tool {

// The outcome of a call: a reply, or the exit code and the reason.
template <class Reply>
struct CallEnd {
  std::optional<Reply> reply;
  ExitCode exit = ExitCode::kDone;
  Error error;
};

// Beyond the time of a sound that is waited for, by the clock of the options.
inline constexpr Duration kLongestCall = std::chrono::seconds(15);

template <msg::Service S>
CallEnd<typename S::Response> Call(program::ToolLink& link, const std::string& service,
                                   const typename S::Request& request) {
  constexpr Duration kForever = std::chrono::hours(1);  // of steady time, while the clock runs
  const auto client = transport::MakeClient<S>(link.node(), link.Name(service));
  if (!client) return {{}, ExitCode::kUsage, client.error()};
  if (!link.AwaitClock()) {
    return {{}, ExitCode::kNotDone, {kCodeTimeout, "no publisher of /clock"}};
  }
  std::optional<Result<typename S::Response>> reply;
  client.value()->Call(request, kForever, [&](auto result) { reply = std::move(result); });
  const auto there = [&] { return client.value()->Ready() || reply; };
  if (!link.Find(there) && !link.interrupted()) {
    return {{}, ExitCode::kNotDone, link.NotFound("audio module")};
  }
  const Time deadline = link.clock().Now() + kLongestCall;
  bool late = false;
  const auto over = link.clock().At(deadline, [&] { late = true; });
  link.RunUntil([&] { return reply || late; }, kForever);
  if (link.interrupted()) {
    return {{}, ExitCode::kInterrupted, {kCodeFailed, "interrupted; the sound continues"}};
  }
  if (!reply) return {{}, ExitCode::kNotDone, {kCodeTimeout, "the audio module does not answer"}};
  if (!*reply) return {{}, ExitCode::kNotDone, reply->error()};
  return {reply->value(), ExitCode::kDone, {}};
}

}  // namespace musher::audio::tool
