#include "musher/cli/commands/behavior_tree.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "musher/cli/console/error_json.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/machine/behavior_request.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/tree.hpp"

namespace musher::cli {
namespace {

using TreeReport = msg::GetTree::Response;

constexpr std::uint32_t kAllTreeChanges = 1000;     // more than a tree remembers
constexpr Duration kRedraw = Milliseconds(500);     // times go on without a change
constexpr std::string_view kHome = "\x1b[H\x1b[J";  // the empty screen of a terminal

// The changes after `last`; all of them if it is not among them.
void KeepNew(const std::optional<msg::TreeChange>& last, std::vector<msg::TreeChange>& changes) {
  if (!last) return;
  const auto found = std::find(changes.rbegin(), changes.rend(), *last);
  if (found != changes.rend()) changes.erase(changes.begin(), found.base());
}

class TreeWatch {
 public:
  TreeWatch(Link& link, const GlobalOptions& global, const ShownTree& shown, Console& console)
      : link_(link), global_(global), shown_(shown), console_(console) {}

  ExitCode Run(const TreeReport& begin) {
    Remember(begin);
    link_.EndWithReader();
    transport::SubscriptionEvents events;
    events.on_writer_lost = [this](transport::EndpointId) { lost_ = true; };
    const auto states = transport::MakeSubscription<msg::TreeState>(
        link_.node(), transport::ResolveName(global_.name_space, shown_.name + "/tree_state"),
        [this](const msg::TreeState&, const transport::SampleInfo&) { changed_ = true; },
        transport::kLatchedQos, std::move(events));
    if (!states) return console_.Fail(states.error());
    // The latched state arrives at once, unless the application exits before it is discovered.
    const bool found = link_.RunUntil([this] { return changed_ || lost_; }, link_.discovery());
    if (!found) lost_ = true;
    while (!link_.interrupted() && console_.HasReader()) {
      link_.RunUntil([this] { return changed_ || lost_; },
                     IsRedrawn() && !gone_ ? kRedraw : Duration(std::chrono::hours(24)));
      if (std::exchange(lost_, false)) {
        PrintLost();
      } else if (changed_ || (IsRedrawn() && !gone_)) {
        changed_ = false;
        PrintNow();
      }
    }
    return ExitCode::kDone;
  }

 private:
  bool IsRedrawn() const { return console_.mode().terminal && !console_.mode().json; }

  void PrintNow() {
    const std::uint32_t history = IsRedrawn() ? shown_.history : kAllTreeChanges;
    const auto answer = QueryTree(link_, global_, shown_.name, {"", history, shown_.entries});
    if (link_.interrupted()) return;
    if (const auto* failure = std::get_if<Failure>(&answer)) return PrintFailure(*failure);
    gone_ = false;
    TreeReport report = std::get<TreeReport>(answer);
    if (IsRedrawn()) {
      return console_.Redraw(std::string(kHome) +
                             TreeText(shown_.name, report, console_.mode().colour));
    }
    const bool other = report.state.revision != revision_;
    const bool paused = report.state.ticking != ticking_;
    if (!other) KeepNew(last_, report.history);
    if (report.history.empty() && !paused && !other) return;
    console_.Print(console_.mode().json ? TreeJson(shown_.name, report)
                                        : TreeLines(report, WallNow(), console_.mode().colour));
    Remember(report);
  }
  // A restarted application begins a new history.
  void PrintLost() {
    last_.reset();
    gone_ = true;
    PrintFailure({ExitCode::kNoController, {kCodeNetError, shown_.name + " is lost"}});
  }
  void PrintFailure(const Failure& failure) {
    if (console_.mode().json) return console_.Print(FailureJson(failure));
    console_.Print(LocalTime(WallNow()) + "  " + failure.error.message);
  }
  void Remember(const TreeReport& report) {
    revision_ = report.state.revision;
    ticking_ = report.state.ticking;
    if (!report.history.empty()) last_ = report.history.back();
  }

  Link& link_;
  const GlobalOptions& global_;
  const ShownTree& shown_;
  Console& console_;
  bool changed_ = false;
  bool lost_ = false;
  bool gone_ = false;  // it is lost, and nothing has come since
  std::uint32_t revision_ = 0;
  bool ticking_ = false;
  std::optional<msg::TreeChange> last_;
};

}  // namespace

ExitCode ShowTree(Link& link, const GlobalOptions& global, const ShownTree& shown,
                  Console& console) {
  const auto answer = QueryTree(
      link, global, shown.name,
      {"", shown.follow ? std::max(kAllTreeChanges, shown.history) : shown.history, shown.entries});
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  const auto& report = std::get<TreeReport>(answer);
  TreeReport first = report;
  if (first.history.size() > shown.history) {
    first.history.erase(first.history.begin(), first.history.end() - shown.history);
  }
  const bool redrawn = shown.follow && console.mode().terminal && !console.mode().json;
  if (redrawn) console.Redraw(kHome);
  console.Print(console.mode().json ? TreeJson(shown.name, first)
                                    : TreeText(shown.name, first, console.mode().colour));
  if (!shown.follow) return ExitCode::kDone;
  return TreeWatch(link, global, shown, console).Run(report);
}

}  // namespace musher::cli
