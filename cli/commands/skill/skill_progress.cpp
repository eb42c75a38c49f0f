#include "musher/cli/commands/skill/skill_progress.hpp"

#include <chrono>

#include "musher/cli/render/skill.hpp"

namespace musher::cli {
namespace {

constexpr const char* kEraseSkillLine = "\r\x1b[K";

}  // namespace

SkillProgress::SkillProgress(transport::EventLoop& loop, const std::string& skill, Console& console)
    : loop_(loop), skill_(skill), console_(console), begin_(loop.Now()) {
  if (!console.mode().terminal || console.mode().json) return;
  ticks_ = loop.Every(std::chrono::seconds(1), [this] { Draw(); });
}

void SkillProgress::Show(const SkillReport& report) {
  const bool same = report == report_;
  report_ = report;
  if (console_.mode().json) return;
  if (console_.mode().terminal) return Draw();
  if (!same) console_.Print(SkillReportLine(report));
}

void SkillProgress::Draw() {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(elapsed()).count();
  console_.Redraw(kEraseSkillLine +
                  SkillProgressText(skill_, report_, seconds, console_.mode().colour));
  drawn_ = true;
}

void SkillProgress::Clear() {
  if (drawn_) console_.Redraw(kEraseSkillLine);
  drawn_ = false;
}

}  // namespace musher::cli
