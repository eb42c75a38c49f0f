#pragma once
// What the links to programs without Musher's contract have in common. Such a program knows nothing
// of epochs, numbers and questions; the link keeps, in its place, the report that an actuator of
// Musher's own would give, and lets one command at a time through to it.
//
//            its server is matched         command            ended
//   (gone) ────────────────────────▶ free ─────────▶ busy ────────────▶ free
//      ▲                               │               │  a newer command waits: one place,
//      └────── no server any more ─────┴───────────────┘  the newest keeps it
//
// Each process behind the name is an incarnation of its own, told apart by its DDS participant: one
// that is started again is matched before the lease of the dead one is over.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/controller/link/actuator_link.hpp"
#include "musher/transport/endpoint.hpp"

namespace musher {

class ForeignLink : public ActuatorLink {
 public:
  void Switch(const SwitchCommand& command) final;
  void Query(const QueryCommand& command) final;
  void OnProcess(std::int32_t pid) final;
  void OnProcessFound(std::int32_t pid) final;
  void OnProcessEnded(std::int32_t pid) final;

 protected:
  // The command that is under way.
  struct Order {
    std::uint64_t number = 0;  // 0: SetUp, which nobody commands
    State target;
    Time deadline{};
    bool queried = false;  // its time is over, somebody wants to know
    bool stopped = false;  // shall end as soon as it can
  };

  // `node` and `config` must outlive the link.
  ForeignLink(transport::Node& node, const MachineConfig& config, std::size_t actuator, Emit emit);

  // What a protocol does. A new process is there, its report is empty; what it was told before is
  // void.
  virtual void OnAppeared() = 0;
  // The process is gone, an order with it.
  virtual void OnGone() = 0;
  // Gets order() done; to end with End().
  virtual void Drive() = 0;
  // Finds out how things stand; to end with AnswerQuery(), or with silence.
  virtual void Inquire(const QueryCommand& query) = 0;

  // For a protocol to call. The participants that serve now, whenever that may have changed.
  void OnServers(std::vector<transport::PeerId> servers);
  void BeginSetUp(Duration budget);
  // The order has ended. Begins the command that waits.
  void End(Verdict verdict, std::int32_t code = kCodeOk, const std::string& message = "");
  // The order had not begun and nobody waits for it any more.
  void DropOrder();
  void AnswerQuery(std::uint64_t number) { Reply(number, true, Verdict::kDone, kCodeOk, ""); }
  void ReportStatus();
  void ReportVanished(const std::string& how);

  bool there() const { return server_ != 0; }
  bool ours() const { return process_ != 0 && !found_; }  // this controller has started its process
  transport::PeerId server() const { return server_; }
  std::optional<Order>& order() { return order_; }
  const std::optional<Order>& order() const { return order_; }
  bool has_waiting() const { return waiting_.has_value(); }
  ActuatorReport& report() { return report_; }
  const ActuatorReport& report() const { return report_; }
  const MachineConfig& machine() const { return config_; }
  const ActuatorConfig& actuator() const { return config_.actuators[actuator_]; }
  transport::Node& node() { return node_; }
  Time Now() const { return node_.loop().Now(); }

 private:
  struct Waiting {
    SwitchCommand command;
    Time since{};
  };

  void Post(std::function<void()> work);
  void Take(const SwitchCommand& command);
  void Take(const QueryCommand& command);
  void Begin(const SwitchCommand& command);
  void BeginWaiting();
  void Appear(transport::PeerId server);
  void Forget();
  void Arrive(const State& target);
  void Reply(std::uint64_t number, bool query, Verdict verdict, std::int32_t code,
             const std::string& message);
  void Refuse(std::uint64_t number, std::int32_t code, const std::string& message) {
    Reply(number, false, Verdict::kRefused, code, message);
  }
  ActuatorReport Stamped();

  transport::Node& node_;
  const MachineConfig& config_;
  const std::size_t actuator_;
  const Emit emit_;
  ActuatorReport report_;
  std::int32_t process_ = 0;
  bool found_ = false;                      // it ran when this controller started
  transport::PeerId server_ = 0;            // the process that counts; 0: none
  std::vector<transport::PeerId> servers_;  // all that serve
  std::set<transport::PeerId> ended_;       // the servers whose process has exited
  std::optional<Order> order_;
  std::optional<Waiting> waiting_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);  // for work that is posted
};

}  // namespace musher
