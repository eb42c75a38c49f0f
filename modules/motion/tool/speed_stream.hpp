#pragma once
// A servo motion by frames, 20 a second of the link's clock, until the speeds end.
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
  void Frame(const Next& next);

  std::unique_ptr<program::ToolLink> link_;
  std::unique_ptr<ServoStream> stream_;
  bool over_ = false;
};

}  // namespace musher::motion::tool
