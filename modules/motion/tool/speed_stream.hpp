#pragma once
// A servo motion by frames, 20 a second of the link's clock, until the speeds end. A stream that
// was broken off for more than 5 s, because this process was stopped or its computer suspended, has
// ended: the body stands since then, and people may be beside it.
//
//   SpeedStream ── Open() ── Run(next) ──▶ nothing: it came to its end
//                      └──────────┴──────▶ the exit code, the reason on stderr; the body has
//                                          received a stop

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "musher/modules/motion/tool/options.hpp"
#include "musher/modules/motion/tool/servo_stream.hpp"
#include "musher/transport/loop_breaks.hpp"

namespace musher::motion::tool {

inline constexpr Duration kStandingUp = std::chrono::seconds(20);  // before the first step

class SpeedStream {
 public:
  // The speed of the next frame; nothing: the end.
  using Next = std::function<std::optional<SpeedLimit>()>;

  static std::variant<std::unique_ptr<SpeedStream>, ExitCode> Open(const GlobalOptions& global,
                                                                   std::int32_t id,
                                                                   std::int32_t source);

  // Streams for at most `longest` of steady time. `what` names it in messages.
  std::optional<ExitCode> Run(Next next, Duration longest, const std::string& what);

  program::ToolLink& link() { return *link_; }
  bool moving() const { return stream_->moving(); }

 private:
  SpeedStream() = default;
  void CheckBreak();
  void Frame(const Next& next);

  std::unique_ptr<program::ToolLink> link_;
  std::unique_ptr<ServoStream> stream_;
  bool over_ = false;
  std::optional<transport::LoopBreaks> breaks_;  // of the link's loop
  std::optional<Duration> broken_off_;           // for so long
};

}  // namespace musher::motion::tool
