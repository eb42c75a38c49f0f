#include "musher/actuator/machine_actuator.hpp"

#include <typeinfo>
#include <utility>

#include "musher/actuator/machine_actuator_impl.hpp"

namespace musher {
namespace {

Result<> FromCode(std::int32_t code) {
  return code == kCodeOk ? Ok() : Result<>(Error{code, ""});
}

}  // namespace

MachineActuator::MachineActuator(const std::string& actuator_name)
    : impl_(std::make_unique<Impl>(actuator_name, [this] { OnEmergencyStop(); })) {}

MachineActuator::~MachineActuator() {
  MUSHER_CHECK(!impl_->started() || !derived_, name(),
               "is destroyed while it is started, and its members are already destroyed; use "
               "Run(), Wait() or musher::ActuatorRunner");
}

Result<> MachineActuator::Init(const std::string& config_file,
                               std::shared_ptr<transport::NodeThread> node) {
  return impl_->Init(config_file, std::move(node));
}

void MachineActuator::RegisterStateCallback(const State& state,
                                            std::function<std::int32_t()> callback) {
  impl_->callbacks().Register(state,
                              [callback = std::move(callback)] { return FromCode(callback()); });
}

void MachineActuator::RegisterStateCallback(const State& state,
                                            std::function<Result<>()> callback) {
  impl_->callbacks().Register(state, std::move(callback));
}

void MachineActuator::RegisterStateCallback(std::function<std::int32_t(const State&)> callback) {
  impl_->callbacks().Register(
      [callback = std::move(callback)](const State& state) { return FromCode(callback(state)); });
}

void MachineActuator::RegisterStateCallback(std::function<Result<>(const State&)> callback) {
  impl_->callbacks().Register(std::move(callback));
}

Result<> MachineActuator::Start() {
  derived_ = typeid(*this) != typeid(MachineActuator);
  return impl_->Start();
}
bool MachineActuator::started() const {
  return impl_->started();
}
Result<> MachineActuator::CheckCallbacks() const {
  return impl_->CheckCallbacks();
}
int MachineActuator::Wait() {
  return impl_->Wait();
}
void MachineActuator::Log(const std::string& text) const {
  Log(LogLevel::kInfo, text);
}
void MachineActuator::Log(LogLevel level, const std::string& text) const {
  impl_->Log(level, text);
}
void MachineActuator::Log(const Error& error) const {
  const LogLevel level = error.code == kCodeOk ? LogLevel::kInfo : LogLevel::kWarning;
  Log(level, WithCode(error.message, error.code));
}
void MachineActuator::GiveUp(const Error& why) {
  impl_->GiveUp(why);
}
void MachineActuator::Shutdown() {
  impl_->Shutdown();
}
bool MachineActuator::StopRequested() const {
  return impl_->stop_requested();
}
void MachineActuator::Checkpoint(std::chrono::nanoseconds allowance) {
  impl_->Checkpoint(allowance);
}
State MachineActuator::CurrentState() const {
  return impl_->current_state();
}
Result<> MachineActuator::Allowed(const std::string& capability, ModuleCode module) const {
  return impl_->Allowed(capability, module);
}
void MachineActuator::ReportDegraded(const Error& why) {
  impl_->degraded().Put(why);
}
void MachineActuator::ReportFault(const Error& fault) {
  impl_->ReportFault(fault);
}
bool MachineActuator::EmergencyStopped() const {
  return impl_->emergency_stopped();
}
bool MachineActuator::HeldByStop() const {
  return impl_->held_by_stop();
}
Result<> MachineActuator::OpenEndpoints(const std::function<void(transport::Endpoints&)>& open) {
  return impl_->OpenEndpoints(open);
}
void MachineActuator::RunOnLoop(const std::function<void()>& work) {
  impl_->RunOnLoop(work);
}
const std::string& MachineActuator::name() const {
  return impl_->name();
}
const MachineConfig& MachineActuator::machine_config() const {
  return impl_->config();
}
std::shared_ptr<transport::NodeThread> MachineActuator::node() const {
  return impl_->node();
}

CallbackHarness::CallbackHarness(MachineActuator& actuator) : actuator_(actuator) {}
std::vector<State> CallbackHarness::States() const {
  return actuator_.impl_->callbacks().States();
}
Result<> CallbackHarness::Adopt(const MachineConfig& config) {
  if (auto adopted = actuator_.impl_->Adopt(config); !adopted) return adopted;
  return actuator_.impl_->CheckCallbacks();
}
void CallbackHarness::SetNode(std::shared_ptr<transport::NodeThread> node) {
  actuator_.impl_->SetNode(std::move(node));
}
Result<> CallbackHarness::Run(const State& state) {
  return actuator_.impl_->callbacks().Run(state);
}
Result<> CallbackHarness::EmergencyStop() {
  return actuator_.impl_->RunEmergencyStop();
}
void CallbackHarness::SetStopRequested(bool requested) {
  actuator_.impl_->set_stop_requested(requested);
}
void CallbackHarness::SetReport(const ActuatorReport& report) {
  actuator_.impl_->gate().SetReport(report);
}
void CallbackHarness::SetBattery(std::optional<int> percent) {
  actuator_.impl_->gate().SetBattery(percent);
}
void CallbackHarness::OnPoll(std::function<void()> on_poll) {
  actuator_.impl_->set_on_poll(std::move(on_poll));
}

}  // namespace musher
