#include "musher/controller/cli/switch_progress.hpp"

#include <chrono>

#include "musher/controller/cli/render/text.hpp"

namespace musher::cli {
namespace {

constexpr Duration kDrawPeriod =
    Milliseconds(500);  // also before the first: most switches end sooner
constexpr const char* kEraseDrawnLine = "\r\x1b[K";

}  // namespace

SwitchProgress::SwitchProgress(Link& link, const std::string& target, Console& console)
    : link_(link), target_(target), console_(console), begin_(link.loop().Now()) {
  if (!console.mode().terminal || console.mode().json) return;
  ticks_ = link.loop().Every(kDrawPeriod, [this] { Draw(); });
}

void SwitchProgress::Draw() {
  if (!link_.status()) return Clear();
  const auto seconds =
      std::chrono::duration_cast<std::chrono::seconds>(link_.loop().Now() - begin_).count();
  const std::string text = SwitchProgressText(*link_.status(), target_, seconds);
  if (text == drawn_) return;
  console_.Redraw(kEraseDrawnLine + text);
  drawn_ = text;
}

void SwitchProgress::Clear() {
  if (!drawn_.empty()) console_.Redraw(kEraseDrawnLine);
  drawn_.clear();
}

}  // namespace musher::cli
