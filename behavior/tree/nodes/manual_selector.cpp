// A child that a person selects, by an entry of the blackboard.

#include <algorithm>
#include <optional>
#include <string>

#include "musher/behavior/tree/factory.hpp"
#include "musher/behavior/tree/setup.hpp"

namespace musher::tree {
namespace {

class ManualSelector : public Control {
 public:
  explicit ManualSelector(Setup& setup)
      : selection_(setup.InOut<std::string>(
            "selection", "the name of a child, SUCCESS or FAILURE; is emptied when it is taken")),
        repeats_(setup.Input<bool>("repeat_last_selection", false,
                                   "selects the last child again where nothing is selected")) {}

 private:
  Status OnTick(Tick& tick) override {
    if (!selected_) {
      const std::string* text = selection_.Find();
      const std::string wanted = text == nullptr ? "" : *text;
      if (wanted.empty() && repeats_.Get()) selected_ = last_;
      const auto found = std::ranges::find(child_names(), wanted);
      if (found != child_names().end()) {
        selected_ = static_cast<std::size_t>(found - child_names().begin());
      }
      const bool ends = wanted == "SUCCESS" || wanted == "FAILURE";
      if (ends || found != child_names().end()) selection_.Set("");
      if (ends && !selected_) {
        return wanted == "SUCCESS" ? Status::kSuccess : Status::kFailure;
      }
      // A wrong name stays for a person to see, until another one is selected.
      if (!selected_) return Status::kRunning;
      last_ = selected_;
    }
    const Status status = children()[*selected_]->Execute(tick);
    if (status == Status::kRunning) return status;
    selected_.reset();
    ResetChildren(tick);
    return status;
  }
  void OnHalt(Tick& tick) override {
    selected_.reset();
    ResetChildren(tick);
  }

  InOutPort<std::string> selection_;
  InPort<bool> repeats_;
  std::optional<std::size_t> selected_;
  std::optional<std::size_t> last_;
};

}  // namespace

void AddManualSelector(Factory& factory) {
  static_cast<void>(factory.Register(
      "ManualSelector", {NodeKind::kControl, true, [](Setup& setup) -> std::unique_ptr<Node> {
                           return std::make_unique<ManualSelector>(setup);
                         }}));
}

}  // namespace musher::tree
